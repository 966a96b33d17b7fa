// SPDX-License-Identifier: Apache-2.0
#include "common/scene/material_bytes.h"

#include <type_traits>

namespace tessera {
namespace {

// Every field of a material in the order of the block, for a writer or for a reader.
template <class Visitor, class M>
void visit(Visitor& v, M& m) {
  v.plain(m.albedo);
  v.plain(m.emission);
  v.texture(m.albedo_texture);
  v.texture(m.emission_texture);
  v.one_of(m.bsdf, last_bsdf());
  v.plain(m.specular);
  v.plain(m.roughness);
  v.plain(m.metalness);
  v.plain(m.ior);
  v.texture(m.roughness_metalness_texture);
  v.texture(m.normal_texture);
  v.plain(m.normal_scale);
  v.plain(m.specular_f90);
  v.texture(m.specular_texture);
  v.texture(m.specular_color_texture);
  v.plain(m.clearcoat.weight);
  v.plain(m.clearcoat.roughness);
  v.texture(m.clearcoat.weight_texture);
  v.texture(m.clearcoat.roughness_texture);
  v.texture(m.clearcoat.normal_texture);
  v.plain(m.clearcoat.normal_scale);
  v.plain(m.sheen.color);
  v.plain(m.sheen.roughness);
  v.texture(m.sheen.color_texture);
  v.texture(m.sheen.roughness_texture);
  v.plain(m.transmission.weight);
  v.texture(m.transmission.weight_texture);
  v.flag(m.transmission.is_thin);
  v.plain(m.transmission.attenuation_color);
  v.plain(m.transmission.attenuation_distance);
  v.plain(m.anisotropy.strength);
  v.plain(m.anisotropy.rotation);
  v.texture(m.anisotropy.texture);
  v.one_of(m.alpha.mode, AlphaMode::kBlend);
  v.plain(m.alpha.value);
  v.plain(m.alpha.cutoff);
  v.texture(m.alpha.texture);
  v.plain(m.alpha.channel);
  v.flag(m.is_double_sided);
  v.flag(m.is_unlit);
  v.one_of(m.surface.kind, SurfaceKind::kBrick);
  v.plain(m.surface.parameters);
}

class Putter {
 public:
  explicit Putter(BlockWriter& out) : out_(out) {}
  template <typename T>
  void plain(const T& value) {
    out_.put(value);
  }
  void flag(bool value) { out_.put(std::uint32_t{value ? 1u : 0u}); }
  template <typename Enum>
  void one_of(Enum value, Enum) {
    out_.put(static_cast<std::uint32_t>(value));
  }
  void texture(const TextureRef& t) {
    out_.put(t.index);
    out_.put(t.uv_set);
    out_.put(t.uv_map);
  }

 private:
  BlockWriter& out_;
};

class Getter {
 public:
  explicit Getter(BlockReader& in) : in_(in) {}
  template <typename T>
  void plain(T& value) {
    value = in_.get<T>();
  }
  void flag(bool& value) { value = in_.get<std::uint32_t>() != 0; }
  template <typename Enum>
  void one_of(Enum& value, Enum last) {
    const auto number = in_.get<std::uint32_t>();
    is_known_ &= number <= static_cast<std::uint32_t>(last);
    if (is_known_) value = static_cast<Enum>(number);
  }
  void texture(TextureRef& t) {
    t.index = in_.get<std::uint32_t>();
    t.uv_set = in_.get<std::uint32_t>();
    t.uv_map = in_.get<std::array<float, 6>>();
  }
  bool is_good() const { return is_known_ && in_.is_good(); }

 private:
  BlockReader& in_;
  bool is_known_ = true;
};

}  // namespace

void put_material(BlockWriter& out, const Material& material) {
  out.put_text(material.name);
  Putter putter(out);
  visit(putter, material);
}

bool get_material(BlockReader& in, Material& material) {
  if (!in.get_text(material.name)) return false;
  Getter getter(in);
  visit(getter, material);
  return getter.is_good();
}

std::uint64_t material_bytes_min() {
  static const std::uint64_t bytes = [] {
    BlockWriter out(BlockKind::kRoot);
    const std::uint64_t head = out.finish().size();
    BlockWriter with(BlockKind::kRoot);
    put_material(with, Material{});
    return with.finish().size() - head;
  }();
  return bytes;
}

}  // namespace tessera
