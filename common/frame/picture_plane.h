// SPDX-License-Identifier: Apache-2.0
// The planes of a picture besides its colour: alpha, and what the camera rays of a pixel have met.
// The row of a plane says what the plane and its channels are called, and how the samples of a
// pixel make one value; everything between the render threads and the file loops over a set of
// planes and knows none by name. A new plane is a row here and its value in
// slave/core/integrate/planes/plane_values.cpp.
//
// Values are float32. A plane of a pixel holds:
//   alpha     share of the samples that have met a surface. Glass and mirrors count as met,
//             whatever is seen in them; a ray that goes through a surface by its alpha has not met
//             it there; every background counts as nothing
//   albedo    what the surface reflects, in [0, 1]; of mirrors and glass their specular colour; of
//             unlit surfaces what they show; 0 where nothing is met
//   normal    shading normal, unit, in world space, on the viewer's side; 0 where nothing is met
//   depth     from the camera, along its view direction, in scene units; infinite where nothing is
//             met
//   position  in world space; 0 where nothing is met
//   object    number of the instance in the scene, from 1; 0 where nothing is met
//   material  number of the material in the scene, from 1; 0 where nothing is met
//   samples   number of samples that were taken of the pixel
// Depth, position, object and material of a pixel are of one and the same hit.
//
// Threads. Plain values and pure functions. Numbers of planes travel on the wire and never change.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "common/base/api.h"
#include "common/base/status.h"

namespace tessera {

enum class Plane : std::uint8_t {
  kAlpha = 0,
  kAlbedo = 1,
  kNormal = 2,
  kDepth = 3,
  kPosition = 4,
  kObject = 5,
  kMaterial = 6,
  kSamples = 7,
};

// How one value is made of the samples of a pixel, and then of the passes of a picture.
enum class PlaneMerge : std::uint8_t {
  kMean = 0,     // of all samples; of all passes
  kNearest = 1,  // of the nearest hit, the first among equals; of the first pass
  kSum = 2,      // of all samples; of all passes
};

struct PlaneRow {
  std::string_view name;
  std::array<std::string_view, 3> channels;  // in an EXR; those that it does not have are empty
  PlaneMerge merge = PlaneMerge::kMean;
  std::string_view option = {};  // flag that adds the plane; empty: it is asked for by name

  constexpr std::size_t channel_count() const {
    return channels[1].empty() ? 1 : channels[2].empty() ? 2 : 3;
  }
};

inline constexpr std::array<PlaneRow, 8> kPlaneRows{{
    {"alpha", {"A"}, PlaneMerge::kMean, "--background transparent"},
    {"albedo", {"albedo.R", "albedo.G", "albedo.B"}},
    {"normal", {"N.X", "N.Y", "N.Z"}},
    {"depth", {"Z"}, PlaneMerge::kNearest},
    {"position", {"P.X", "P.Y", "P.Z"}, PlaneMerge::kNearest},
    {"object", {"object"}, PlaneMerge::kNearest},
    {"material", {"material"}, PlaneMerge::kNearest},
    {"samples", {"samples"}, PlaneMerge::kSum},
}};

inline constexpr std::size_t kPlanesMax = 32;  // bits of a set

// Rows of planes that are numbered after kPlaneRows. There are none; a test that has a plane of its
// own links its rows in their place (more_planes.cpp).
std::span<const PlaneRow> more_plane_rows();

TESSERA_API std::size_t plane_count();
// Requires: the plane's number is below plane_count().
TESSERA_API const PlaneRow& plane_row(Plane plane);

class PlaneSet {
 public:
  constexpr PlaneSet() = default;
  constexpr PlaneSet(std::initializer_list<Plane> planes) {
    for (const Plane plane : planes) add(plane);
  }
  // Requires: bits of planes that there are.
  static constexpr PlaneSet of_bits(std::uint32_t bits) {
    PlaneSet set;
    set.bits_ = bits;
    return set;
  }
  TESSERA_API static PlaneSet all();

  constexpr void add(Plane plane) { bits_ |= bit(plane); }
  constexpr bool has(Plane plane) const { return (bits_ & bit(plane)) != 0; }
  constexpr bool is_empty() const { return bits_ == 0; }
  constexpr std::uint32_t bits() const { return bits_; }
  constexpr bool operator==(const PlaneSet&) const = default;

  // Calls function(plane) for each plane of the set, by rising number.
  template <class Function>
  void for_each(const Function& function) const {
    for (std::uint32_t left = bits_; left != 0; left &= left - 1)
      function(static_cast<Plane>(std::countr_zero(left)));
  }

 private:
  static constexpr std::uint32_t bit(Plane plane) {
    return std::uint32_t{1} << static_cast<unsigned>(plane);
  }
  std::uint32_t bits_ = 0;
};

// Floats of a pixel in all planes of the set.
TESSERA_API std::size_t channel_count(PlaneSet planes);

// Parses names of planes that a person asks for, such as "albedo,depth", each at most once.
// Returns: kInvalidArgument with the names that there are.
TESSERA_API Result<PlaneSet> parse_planes(std::string_view text);
// Names of all planes that a person can ask for: "albedo, normal, ...".
std::string aov_names();

}  // namespace tessera
