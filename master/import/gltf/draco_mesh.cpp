// SPDX-License-Identifier: Apache-2.0
#include "master/import/gltf/draco_mesh.h"

#include <draco/compression/decode.h>

#include <limits>

namespace tessera::import {
namespace {

constexpr std::uint64_t kAttributeIdMax = 0xffffffffu;

// The worth of one unit of integers that the accessor calls normalised.
float scale_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return 1.0f / 127;
    case draco::DT_UINT8:
      return 1.0f / 255;
    case draco::DT_INT16:
      return 1.0f / 32767;
    case draco::DT_UINT16:
      return 1.0f / 65535;
    default:
      return 1;
  }
}

template <typename T>
bool append(const draco::PointAttribute& attribute, draco::AttributeValueIndex index, float scale,
            std::vector<float>& values) {
  T element[4] = {};
  const auto components = static_cast<std::int8_t>(attribute.num_components());
  if (!attribute.ConvertValue<T>(index, components, element)) return false;
  for (std::int8_t i = 0; i < components; ++i) {
    const float value = static_cast<float>(element[i]) * scale;
    values.push_back(scale < 1 ? std::max(value, -1.0f) : value);
  }
  return true;
}

// Integers are read as integers, since the library would scale those that it takes for normalised.
bool read_attribute(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
                    bool is_normalized, std::vector<float>& values) {
  const bool is_real =
      attribute.data_type() == draco::DT_FLOAT32 || attribute.data_type() == draco::DT_FLOAT64;
  const float scale = is_normalized && !is_real ? scale_of(attribute.data_type()) : 1;
  values.reserve(std::size_t{mesh.num_points()} *
                 static_cast<std::size_t>(attribute.num_components()));
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex index = attribute.mapped_index(point);
    if (index.value() >= attribute.size()) return false;
    if (!(is_real ? append<float>(attribute, index, scale, values)
                  : append<std::int32_t>(attribute, index, scale, values)))
      return false;
  }
  return true;
}

Result<bool> is_normalized(GltfDocument& document, const GltfObject& attributes,
                           const std::string& name) {
  const auto accessor = attributes.refused_index(name, document.count("accessors"));
  if (!accessor.is_ok()) return accessor.status();
  return *accessor && document.at("accessors", **accessor).flag("normalized", false);
}

}  // namespace

Result<DracoMesh> unpack_draco(GltfDocument& document, const GltfObject& packed,
                               const GltfObject& attributes) {
  packed.check_keys({"bufferView", "attributes"}, {});
  const auto view = packed.refused_index("bufferView", document.count("bufferViews"));
  if (!view.is_ok()) return view.status();
  if (!*view) return packed.refuse("bufferView", "is missing");
  const auto bytes = document.view(**view);
  if (!bytes.is_ok()) return bytes.status();
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    return packed.refuse("bufferView",
                         "holds no packed mesh: " + printable(decoded.status().error_msg_string()));
  }
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  DracoMesh unpacked;
  for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& point : mesh->face(f)) unpacked.indices.push_back(point.value());
  }
  const GltfObject names = packed.object("attributes");
  for (const std::string& name : names.keys()) {
    const auto id = names.refused_whole(name, 0, 0, kAttributeIdMax);
    if (!id.is_ok()) return id.status();
    const draco::PointAttribute* const attribute =
        mesh->GetAttributeByUniqueId(static_cast<std::uint32_t>(*id));
    if (attribute == nullptr || attribute->num_components() < 1 || attribute->num_components() > 4)
      return names.refuse(printable(name), "is not among the packed attributes");
    const auto scaled = is_normalized(document, attributes, name);
    if (!scaled.is_ok()) return scaled.status();
    unpacked.values.push_back(std::make_unique<std::vector<float>>());
    if (!read_attribute(*mesh, *attribute, *scaled, *unpacked.values.back()))
      return names.refuse(printable(name), "is damaged");
    unpacked.attributes.emplace(
        name, GltfAccessor::of_floats(*unpacked.values.back(),
                                      static_cast<std::size_t>(attribute->num_components())));
  }
  return unpacked;
}

}  // namespace tessera::import
