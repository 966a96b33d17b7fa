// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/accessor.h"

#include <algorithm>
#include <cstring>

namespace tessera::import {
namespace {

constexpr std::uint64_t kCountMax = 0xfffffffeu;
constexpr std::uint64_t kOffsetMax = std::uint64_t{1} << 40;
// An accessor without bytes costs its file nothing, so it may not ask for much: so many positions
// are 200 MB.
constexpr std::uint64_t kZerosCountMax = std::uint64_t{1} << 24;

struct Shape {
  const char* name;
  std::size_t components, columns;
};
constexpr Shape kShapes[] = {{"SCALAR", 1, 1}, {"VEC2", 2, 1}, {"VEC3", 3, 1}, {"VEC4", 4, 1},
                             {"MAT2", 4, 2},   {"MAT3", 9, 3}, {"MAT4", 16, 4}};

// Columns of matrices begin at multiples of four bytes.
std::size_t element_bytes(const Shape& shape, std::size_t component_bytes) {
  const std::size_t column = shape.components / shape.columns * component_bytes;
  return shape.columns == 1 ? column : (column + 3) / 4 * 4 * shape.columns;
}

template <typename T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(value));
  return value;
}

// A component as a real number; integers are normalised as glTF 2.0, section 3.11, says.
template <typename T>
float real(const std::byte* from, bool is_normalized) {
  const float value = static_cast<float>(load<T>(from));
  if (!is_normalized) return value;
  return std::max(value / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
}

float real(const std::byte* from, ComponentType type, bool is_normalized) {
  switch (type) {
    case ComponentType::kInt8:
      return real<std::int8_t>(from, is_normalized);
    case ComponentType::kUint8:
      return real<std::uint8_t>(from, is_normalized);
    case ComponentType::kInt16:
      return real<std::int16_t>(from, is_normalized);
    case ComponentType::kUint16:
      return real<std::uint16_t>(from, is_normalized);
    case ComponentType::kUint32:
      return real<std::uint32_t>(from, is_normalized);
    default:
      return load<float>(from);
  }
}

std::uint32_t whole(const std::byte* from, ComponentType type) {
  switch (type) {
    case ComponentType::kUint8:
      return load<std::uint8_t>(from);
    case ComponentType::kUint16:
      return load<std::uint16_t>(from);
    default:
      return load<std::uint32_t>(from);
  }
}

// `size` bytes of the view that `source` names, from its byteOffset.
Result<ByteSpan> part_of_view(GltfDocument& document, const GltfObject& source, std::uint64_t size,
                              const std::string& what) {
  const auto view = source.refused_index("bufferView", document.count("bufferViews"));
  if (!view.is_ok()) return view.status();
  if (!*view) return source.refuse("bufferView", "is missing");
  const auto offset = source.refused_whole("byteOffset", 0, 0, kOffsetMax);
  if (!offset.is_ok()) return offset.status();
  const auto bytes = document.view(**view);
  if (!bytes.is_ok()) return bytes.status();
  if (*offset > bytes->size() || size > bytes->size() - *offset) {
    return source.refuse("count", "asks for " + what + ", which end " +
                                      std::to_string(*offset + size - bytes->size()) +
                                      " bytes behind bufferView " + std::to_string(**view));
  }
  return bytes->subspan(*offset, size);
}

Result<ComponentType> component_type(const GltfObject& source) {
  const auto number = source.refused_whole("componentType", 0, 5120, 5126);
  if (!number.is_ok()) return number.status();
  const auto type = static_cast<ComponentType>(*number);
  if (bytes_of(type) == 0)
    return source.refuse("componentType", "is " + std::to_string(*number) +
                                              "; it must be 5120 to 5123, 5125 or 5126");
  return type;
}

}  // namespace

std::size_t bytes_of(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8:
    case ComponentType::kUint8:
      return 1;
    case ComponentType::kInt16:
    case ComponentType::kUint16:
      return 2;
    case ComponentType::kUint32:
    case ComponentType::kFloat:
      return 4;
  }
  return 0;
}

Result<GltfAccessor> GltfAccessor::open(GltfDocument& document, std::size_t index) {
  const GltfObject source = document.at("accessors", index);
  source.check_keys({"bufferView", "byteOffset", "componentType", "normalized", "count", "type",
                     "max", "min", "sparse"},
                    {});
  GltfAccessor accessor;
  accessor.name_ = source.name();
  const auto type = component_type(source);
  if (!type.is_ok()) return type.status();
  accessor.type_ = *type;
  accessor.is_normalized_ = source.flag("normalized", false) && *type != ComponentType::kFloat;
  if (!source.has("count")) return source.refuse("count", "is missing");
  const auto count = source.refused_whole("count", 0, 1, kCountMax);
  if (!count.is_ok()) return count.status();
  accessor.count_ = *count;
  const std::string shape_name = source.text("type");
  const auto* const shape = std::find_if(std::begin(kShapes), std::end(kShapes),
                                         [&](const Shape& s) { return s.name == shape_name; });
  if (shape == std::end(kShapes)) {
    return source.refuse("type", "is '" + printable(shape_name) +
                                     "'; it must be SCALAR, VEC2 to VEC4 or MAT2 to MAT4");
  }
  accessor.components_ = shape->components;
  accessor.element_bytes_ = element_bytes(*shape, bytes_of(*type));
  accessor.stride_ = accessor.element_bytes_;
  TESSERA_RETURN_IF_ERROR(accessor.open_bytes(document, source));
  const GltfObject sparse = source.object("sparse");
  if (sparse.is_there()) TESSERA_RETURN_IF_ERROR(accessor.open_sparse(document, sparse));
  return accessor;
}

GltfAccessor GltfAccessor::of_floats(std::span<const float> values, std::size_t components) {
  GltfAccessor accessor;
  accessor.name_ = "decoded accessor";
  accessor.components_ = components;
  accessor.element_bytes_ = accessor.stride_ = components * sizeof(float);
  accessor.count_ = values.size() / components;
  accessor.bytes_ = std::as_bytes(values);
  return accessor;
}

Status GltfAccessor::open_bytes(GltfDocument& document, const GltfObject& source) {
  if (!source.has("bufferView")) {
    if (count_ <= kZerosCountMax) return Status::ok();
    return source.refuse("count", "is " + std::to_string(count_) +
                                      ", too much for an accessor without a bufferView");
  }
  const auto view = source.refused_index("bufferView", document.count("bufferViews"));
  if (!view.is_ok()) return view.status();
  const GltfObject of_view = document.at("bufferViews", **view);
  const auto stride = of_view.refused_whole("byteStride", element_bytes_, 1, 252);
  if (!stride.is_ok()) return stride.status();
  if (*stride < element_bytes_) {
    return of_view.refuse("byteStride", "is " + std::to_string(*stride) + ", but an element of " +
                                            name_ + " has " + std::to_string(element_bytes_) +
                                            " bytes");
  }
  stride_ = *stride;
  auto bytes = part_of_view(document, source, (count_ - 1) * stride_ + element_bytes_,
                            std::to_string(count_) + " elements");
  if (!bytes.is_ok()) return bytes.status();
  bytes_ = *bytes;
  return Status::ok();
}

Status GltfAccessor::open_sparse(GltfDocument& document, const GltfObject& sparse) {
  sparse.check_keys({"count", "indices", "values"}, {});
  const auto count = sparse.refused_whole("count", 0, 1, count_);
  if (!count.is_ok()) return count.status();
  const GltfObject indices = sparse.object("indices"), values = sparse.object("values");
  if (!indices.is_there()) return sparse.refuse("indices", "are missing");
  if (!values.is_there()) return sparse.refuse("values", "are missing");
  indices.check_keys({"bufferView", "byteOffset", "componentType"}, {});
  values.check_keys({"bufferView", "byteOffset"}, {});
  const auto type = component_type(indices);
  if (!type.is_ok()) return type.status();
  if (*type != ComponentType::kUint8 && *type != ComponentType::kUint16 &&
      *type != ComponentType::kUint32)
    return indices.refuse("componentType", "must be unsigned");
  const std::size_t size = bytes_of(*type);
  const std::string what = std::to_string(*count) + " sparse elements";
  const auto from = part_of_view(document, indices, *count * size, what);
  if (!from.is_ok()) return from.status();
  auto to = part_of_view(document, values, *count * element_bytes_, what);
  if (!to.is_ok()) return to.status();
  replaced_.reserve(*count);
  for (std::size_t i = 0; i < *count; ++i) {
    const std::uint32_t element = whole(from->data() + i * size, *type);
    if (element >= count_ || (i > 0 && element <= replaced_.back()))
      return indices.refuse("bufferView", "holds " + std::to_string(element) + " at " +
                                              std::to_string(i) +
                                              "; indices must rise and be below the count");
    replaced_.push_back(element);
  }
  replacements_ = *to;
  return Status::ok();
}

const std::byte* GltfAccessor::at(std::size_t element) const {
  if (!replaced_.empty()) {
    const auto found = std::lower_bound(replaced_.begin(), replaced_.end(), element);
    if (found != replaced_.end() && *found == element) {
      return replacements_.data() +
             static_cast<std::size_t>(found - replaced_.begin()) * element_bytes_;
    }
  }
  return bytes_.empty() ? nullptr : bytes_.data() + element * stride_;
}

void GltfAccessor::read_to(std::size_t element, std::span<float> values) const {
  const std::byte* from = at(element);
  if (from == nullptr) return;
  const std::size_t size = bytes_of(type_);
  for (std::size_t i = 0; i < std::min(components_, values.size()); ++i)
    values[i] = real(from + i * size, type_, is_normalized_);
}

std::array<float, 4> GltfAccessor::read(std::size_t element) const {
  std::array<float, 4> values{};
  read_to(element, values);
  return values;
}

std::array<float, 16> GltfAccessor::read_matrix(std::size_t element) const {
  std::array<float, 16> values{};
  read_to(element, values);
  return values;
}

std::uint32_t GltfAccessor::read_index(std::size_t element) const {
  const std::byte* from = at(element);
  return from == nullptr ? 0 : whole(from, type_);
}

}  // namespace tessera::import
