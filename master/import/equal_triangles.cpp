// SPDX-License-Identifier: Apache-2.0
#include "master/import/equal_triangles.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <unordered_map>
#include <vector>

namespace tessera::import {
namespace {

using Corner = std::array<std::uint32_t, 3>;  // bits of a place
using Place = std::array<Corner, 3>;          // in rising order

Corner corner_of(Vec3f v) {
  // A zero with a sign is the same place as one without.
  return {std::bit_cast<std::uint32_t>(v.x + 0.0f), std::bit_cast<std::uint32_t>(v.y + 0.0f),
          std::bit_cast<std::uint32_t>(v.z + 0.0f)};
}

// Odd multipliers spread the bits (Knuth, "The Art of Computer Programming", volume 3, 6.4).
std::uint32_t hash_of(const Corner& c) {
  std::uint32_t h =
      c[0] * 0x9e3779b1u ^ std::rotl(c[1] * 0x85ebca77u, 11) ^ std::rotl(c[2] * 0xc2b2ae3du, 22);
  h ^= h >> 15;
  return h * 0x27d4eb2fu;
}

struct HashOfPlace {
  std::size_t operator()(const Place& place) const {
    return hash_of(place[0]) + 3 * std::size_t{hash_of(place[1])} +
           5 * std::size_t{hash_of(place[2])};
  }
};

// Counts triangles by a hash of their place in as many small counters as there are triangles. Where
// one has passed the bound, there may be that many equal ones; in most meshes none has.
class Sketch {
 public:
  explicit Sketch(const Mesh& mesh) {
    hashes_.reserve(mesh.positions.size());
    for (const Vec3f& v : mesh.positions) hashes_.push_back(hash_of(corner_of(v)));
    const auto bits = std::bit_width(std::max<std::size_t>(mesh.triangles.size(), kLeast));
    shift_ = 32 - std::min(static_cast<int>(bits), kBitsMax);
    counts_.resize(std::size_t{1} << (32 - shift_));
    for (const auto& t : mesh.triangles) {
      std::uint8_t& count = counts_[at(t)];
      if (count <= kEqualTrianglesMax) ++count;
      has_many_ = has_many_ || count > kEqualTrianglesMax;
    }
  }
  bool has_many() const { return has_many_; }
  bool may_be_one_of_many(const std::array<std::uint32_t, 3>& t) const {
    return counts_[at(t)] > kEqualTrianglesMax;
  }

 private:
  static constexpr std::size_t kLeast = 4096;
  static constexpr int kBitsMax = 30;
  // The sum does not depend on the order of the corners.
  std::size_t at(const std::array<std::uint32_t, 3>& t) const {
    return (hashes_[t[0]] + hashes_[t[1]] + hashes_[t[2]]) * 0x9e3779b1u >> shift_;
  }

  std::vector<std::uint32_t> hashes_;  // [vertex]
  std::vector<std::uint8_t> counts_;
  int shift_ = 0;
  bool has_many_ = false;
};

Place place_of(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  Place place{corner_of(mesh.positions[t[0]]), corner_of(mesh.positions[t[1]]),
              corner_of(mesh.positions[t[2]])};
  std::sort(place.begin(), place.end());
  return place;
}

// Returns: the mesh without them, or null where there are none.
std::shared_ptr<const Mesh> without_equal(const Mesh& mesh) {
  if (mesh.triangles.size() <= kEqualTrianglesMax) return nullptr;
  const Sketch sketch(mesh);
  if (!sketch.has_many()) return nullptr;
  std::unordered_map<Place, std::uint32_t, HashOfPlace> counts;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    if (!sketch.may_be_one_of_many(t) || ++counts[place_of(mesh, t)] <= kEqualTrianglesMax)
      kept.push_back(i);
  }
  if (kept.size() == mesh.triangles.size()) return nullptr;
  auto lighter = std::make_shared<Mesh>(mesh);
  const bool has_materials = mesh.materials.size() > 1;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    lighter->triangles[i] = mesh.triangles[kept[i]];
    if (has_materials) lighter->materials[i] = mesh.materials[kept[i]];
  }
  lighter->triangles.resize(kept.size());
  if (has_materials) lighter->materials.resize(kept.size());
  return lighter;
}

}  // namespace

std::uint64_t leave_out_equal(Scene& scene) {
  std::uint64_t count = 0;
  for (auto& mesh : scene.meshes) {
    if (auto lighter = without_equal(*mesh)) {
      count += mesh->triangles.size() - lighter->triangles.size();
      mesh = std::move(lighter);
    }
  }
  return count;
}

}  // namespace tessera::import
