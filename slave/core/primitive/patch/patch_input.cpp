// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/patch_input.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "common/math/bounds3.h"

namespace tessera::core {
namespace {

Status wrong(const std::string& what) { return Status::invalid_argument("patch: " + what); }

}  // namespace

Result<CheckedPatch> checked_patch(const PatchInput& input) {
  for (const int degree : {input.degree_u, input.degree_v})
    if (degree < 1 || degree > kPatchDegreeMax)
      return wrong("degree " + std::to_string(degree) + ", allowed are 1 to " +
                   std::to_string(kPatchDegreeMax));
  const auto count = static_cast<std::size_t>((input.degree_u + 1) * (input.degree_v + 1));
  const std::size_t width = input.is_rational ? 4 : 3;
  if (input.numbers.size() != count * width)
    return wrong(std::to_string(input.numbers.size()) + " numbers, its degrees ask for " +
                 std::to_string(count * width));
  CheckedPatch result{{input.numbers.begin(), input.numbers.end()},
                      0,
                      input.degree_u,
                      input.degree_v,
                      input.is_rational};
  Bounds3f box;
  for (std::size_t k = 0; k < count; ++k) {
    const float* p = input.numbers.data() + k * width;
    for (std::size_t a = 0; a < width; ++a)
      if (!std::isfinite(p[a]))
        return wrong("a number of point " + std::to_string(k) + " is not finite");
    if (input.is_rational && !(p[3] > 0))
      return wrong("the weight of point " + std::to_string(k) + " is not above 0");
    box.grow(Vec3f{p[0], p[1], p[2]});
  }
  for (int a = 0; a < 3; ++a)
    result.extent = std::max(result.extent, double{box.upper[a]} - double{box.lower[a]});
  if (!(result.extent > 0)) return wrong("all points are in one place");
  return result;
}

}  // namespace tessera::core
