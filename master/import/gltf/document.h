// SPDX-License-Identifier: Apache-2.0
// A glTF 2.0 file, text (.gltf) or binary (.glb): its JSON, and the bytes of its buffers, each read
// when it is first asked for (Khronos, "glTF 2.0 specification", 2021, sections 3 and 4).
//
// Bytes come from the binary chunk, from data URIs and from files below the scene's own folder.
// Threads. One. Objects and spans that are handed out point into the document.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/scene_io/warning_group.h"
#include "master/import/gltf/object.h"

namespace tessera::import {

using ByteSpan = std::span<const std::byte>;

class GltfDocument {
 public:
  // Requires: `warnings` outlives it.
  // Returns: kInvalidArgument naming the place for a file that is neither JSON nor GLB or is of
  // another version, or the error of the file system.
  static Result<std::unique_ptr<GltfDocument>> open(const std::string& path,
                                                    WarningGroup& warnings);
  ~GltfDocument();
  GltfDocument(const GltfDocument&) = delete;
  GltfDocument& operator=(const GltfDocument&) = delete;

  const GltfObject& root() const { return root_; }
  WarningGroup& warnings() { return warnings_; }
  const std::string& folder() const { return folder_; }

  // The number of elements of a top-level array ("materials"), and one of its elements, which
  // messages call "material 3 'Leaf'". Requires of at(): index < count(array).
  std::size_t count(std::string_view array) const;
  GltfObject at(std::string_view array, std::size_t index) const;

  // The bytes of a buffer or of a buffer view. Returns: an error that names it.
  // Requires: the index is below the count.
  Result<ByteSpan> buffer(std::size_t index);
  Result<ByteSpan> view(std::size_t index);

 private:
  struct Json;  // keeps the library's headers out of ours

  GltfDocument(std::string path, WarningGroup& warnings);
  Status parse();
  Result<std::string_view> split_glb();
  Status check_asset();
  Result<ByteSpan> read_buffer(std::size_t index);
  Result<ByteSpan> read_view(std::size_t index);

  const std::string path_, folder_;
  WarningGroup& warnings_;
  std::string file_;  // all bytes of the file
  std::optional<ByteSpan> binary_chunk_;
  std::unique_ptr<Json> json_;
  GltfObject root_;
  std::vector<std::optional<ByteSpan>> buffers_, views_;
  std::vector<std::unique_ptr<std::string>> owned_;  // bytes behind buffers_, views_
};

// The singular of an array's name: "mesh" of "meshes".
std::string singular(std::string_view array);

}  // namespace tessera::import
