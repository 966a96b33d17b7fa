// SPDX-License-Identifier: Apache-2.0
#include "common/scene/validate_surface.h"

#include <cmath>
#include <cstdint>

#include "common/base/limits.h"

namespace tessera {
namespace {

constexpr const char* kDegreeRule = " must lie in 1 to 15";
static_assert(kPatchDegreesMax == 15);

Status wrong(const std::string& text) { return Status::invalid_argument(text); }

std::string part(const std::string& whole, const char* what, std::size_t number) {
  return whole + ", " + what + " " + std::to_string(number);
}

bool is_weight(float weight) { return weight > 0 && std::isfinite(weight); }
bool is_degree(std::uint8_t degree) { return degree >= 1 && degree <= kPatchDegreesMax; }

// Checks what the places of patches in the arrays follow from.
Status validate_forms(const PatchSurface& surface, const std::string& name) {
  if (surface.patches.size() > kPatchesMax)
    return Status::resource_exhausted(name + ": more than 2^24 patches");
  std::size_t number_count = 0;
  for (std::size_t i = 0; i < surface.patches.size(); ++i) {
    const PatchForm& form = surface.patches[i];
    if (!is_degree(form.degree_u) || !is_degree(form.degree_v))
      return wrong(part(name, "patch", i) + ": degrees" + kDegreeRule);
    if (form.is_rational > 1 || form.keeps_outside > 1)
      return wrong(part(name, "patch", i) + ": its flags must be 0 or 1");
    number_count += form.number_count();
  }
  if (surface.numbers.size() != number_count) {
    return wrong(name + ": has " + std::to_string(surface.numbers.size()) +
                 " numbers of points, but its patches take " + std::to_string(number_count));
  }
  return Status::ok();
}

Status validate_points(const PatchCursor& patch, const std::string& surface_name) {
  const auto name = [&] { return part(surface_name, "patch", patch.patch()); };
  bool is_one_place = true;
  for (std::size_t i = 0; i < patch.form().point_count(); ++i) {
    if (!is_finite(patch.point(i))) return wrong(part(name(), "point", i) + " is not finite");
    if (!is_weight(patch.weight(i)))
      return wrong(part(name(), "point", i) + ": the weight must be finite and > 0");
    is_one_place = is_one_place && patch.point(i) == patch.point(0);
  }
  return is_one_place ? wrong(name() + ": all its points are in one place") : Status::ok();
}

// Checks that loops, segments and their points are as many as are counted.
Status validate_trim_counts(const PatchSurface& surface, const std::string& name) {
  const std::size_t segment_count = surface.degrees.size();
  std::uint64_t loops = 0, segments = 0, points = 0;
  for (const std::uint32_t count : surface.loop_counts) loops += count;
  for (const std::uint32_t count : surface.segment_counts) segments += count;
  for (const std::uint8_t degree : surface.degrees) points += degree;
  if (!surface.loop_counts.empty() && surface.loop_counts.size() != surface.patches.size())
    return wrong(name + ": needs a count of loops for each patch, or none");
  if (segment_count > kTrimSegmentsMax)
    return Status::resource_exhausted(name + ": more than 2^26 segments of loops");
  if (points + surface.segment_counts.size() > kTrimPointsMax)
    return Status::resource_exhausted(name + ": more than 2^27 - 16 points and loops of its trims");
  if (loops != surface.segment_counts.size())
    return wrong(name + ": its loops are not as many as its patches count");
  if (segments != segment_count)
    return wrong(name + ": its segments are not as many as its loops count");
  if (points != surface.trim_points.size())
    return wrong(name + ": the points of its loops do not fit the degrees");
  if (!surface.trim_widths.empty() && surface.trim_widths.size() != segment_count)
    return wrong(name + ": needs a width for each segment, or none");
  return Status::ok();
}

bool is_in_square(const TrimPoint& p) { return p.u >= 0 && p.u <= 1 && p.v >= 0 && p.v <= 1; }

Status validate_loops(const PatchSurface& surface, const PatchCursor& patch,
                      const std::string& surface_name) {
  std::size_t segment = patch.first_segment(), point = patch.first_trim_point();
  for (std::size_t i = 0; i < patch.loop_count(); ++i) {
    const auto loop = [&] { return part(part(surface_name, "patch", patch.patch()), "loop", i); };
    const std::uint32_t count = surface.segment_counts[patch.first_loop() + i];
    if (count == 0) return wrong(loop() + ": has no segment");
    const std::size_t first_point = point;
    bool is_one_place = true;
    for (std::uint32_t s = 0; s < count; ++s, ++segment) {
      if (!is_degree(surface.degrees[segment]))
        return wrong(part(loop(), "segment", s) + ": its degree" + kDegreeRule);
      const std::size_t end = point + surface.degrees[segment];
      for (; point < end; ++point) {
        const TrimPoint &p = surface.trim_points[point], &first = surface.trim_points[first_point];
        if (!is_in_square(p))  // NaN is not
          return wrong(part(loop(), "point", point - first_point) + " lies outside [0, 1]^2");
        if (!is_weight(p.weight))
          return wrong(part(loop(), "point", point - first_point) +
                       ": the weight must be finite and > 0");
        is_one_place = is_one_place && p.u == first.u && p.v == first.v;
      }
      if (!surface.trim_widths.empty() &&
          !(std::isfinite(surface.trim_widths[segment]) && surface.trim_widths[segment] >= 0))
        return wrong(part(loop(), "segment", s) + ": its width must be finite and >= 0");
    }
    if (is_one_place) return wrong(loop() + ": all its points are in one place");
  }
  return Status::ok();
}

}  // namespace

Status validate_surface(const PatchSurface& surface, const std::string& name,
                        std::size_t material_count) {
  TESSERA_RETURN_IF_ERROR(validate_forms(surface, name));
  TESSERA_RETURN_IF_ERROR(validate_trim_counts(surface, name));
  if (surface.materials.size() != 1 && surface.materials.size() != surface.patches.size())
    return wrong(name + ": needs one material, or one for each patch");
  for (const std::uint32_t material : surface.materials) {
    if (material >= material_count) {
      return wrong(name + ": material " + std::to_string(material) + " of " +
                   std::to_string(material_count));
    }
  }
  for (PatchCursor patch(surface); patch.is_any(); patch.advance()) {
    TESSERA_RETURN_IF_ERROR(validate_points(patch, name));
    TESSERA_RETURN_IF_ERROR(validate_loops(surface, patch, name));
  }
  return Status::ok();
}

}  // namespace tessera
