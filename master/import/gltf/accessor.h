// SPDX-License-Identifier: Apache-2.0
// Reads the numbers of a glTF accessor element by element (glTF 2.0, section 3.6.2): all component
// types, normalised or not. An accessor may be strided or sparse; one without bytes holds zeros.
//
// Invariant. Every element below count() lies inside of the bytes: open() has checked it.
// Threads. Plain value that points into the document.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/status.h"
#include "master/import/gltf/document.h"

namespace tessera::import {

enum class ComponentType : std::uint32_t {
  kInt8 = 5120,
  kUint8 = 5121,
  kInt16 = 5122,
  kUint16 = 5123,
  kUint32 = 5125,
  kFloat = 5126
};
// The bytes of one component. Returns: 0 for a number that is none of these types.
std::size_t bytes_of(ComponentType type);

class GltfAccessor {
 public:
  // Returns: an error that names accessor and key. Requires: index < count("accessors").
  static Result<GltfAccessor> open(GltfDocument& document, std::size_t index);
  // An accessor of packed floats. Requires: `values` outlives the accessor.
  static GltfAccessor of_floats(std::span<const float> values, std::size_t components);

  std::size_t count() const { return count_; }
  std::size_t components() const { return components_; }  // 1 to 4, or 4, 9, 16 of a matrix
  ComponentType type() const { return type_; }
  bool is_normalized() const { return is_normalized_; }
  const std::string& name() const { return name_; }  // "accessor 7", for messages

  // The first four components, zero where there are fewer. Requires: element < count().
  std::array<float, 4> read(std::size_t element) const;
  // A matrix by columns; zeros where the accessor has fewer than 16 components.
  std::array<float, 16> read_matrix(std::size_t element) const;
  // The first component of an unsigned type. Requires: element < count().
  std::uint32_t read_index(std::size_t element) const;

 private:
  const std::byte* at(std::size_t element) const;
  void read_to(std::size_t element, std::span<float> values) const;
  Status open_bytes(GltfDocument& document, const GltfObject& source);
  Status open_sparse(GltfDocument& document, const GltfObject& sparse);

  std::string name_;
  ComponentType type_ = ComponentType::kFloat;
  bool is_normalized_ = false;
  std::size_t components_ = 1, element_bytes_ = 4, stride_ = 4, count_ = 0;
  ByteSpan bytes_;  // empty: zeros
  // The elements that a sparse accessor replaces, in rising order, and their packed values.
  std::vector<std::uint32_t> replaced_;
  ByteSpan replacements_;
};

}  // namespace tessera::import
