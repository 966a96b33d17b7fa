// SPDX-License-Identifier: Apache-2.0
// How many polynomial bicubic patches stand for the patches of CAD files, and how far they are off:
// the degree reduction by subdivision of C. Benthin, "Realtime Ray Tracing on Current CPU
// Architectures" (2006), chapter 6, which the core does not use.
//
//   cad_cubics FILE...
//
// A part is the bicubic patch through 4 x 4 points of it. Where that is more than the tolerance off
// at one of 9 x 9 points of the same parameters, the part is halved in the direction in which it is
// worse off. Prints a line of JSON for each file and tolerance, which is of the diagonal.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <span>
#include <string>

#include "common/base/json.h"
#include "common/math/vec3d.h"
#include "master/import/cad/reader.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/patch_input.h"

namespace tessera::bench {
namespace {

constexpr int kHalvingsMax = 12;  // in each direction
constexpr int kSide = 8;          // steps in which a part is looked at

struct Part {
  double u0 = 0, u1 = 1, v0 = 0, v1 = 1;
  int halvings_u = 0, halvings_v = 0;
};

struct Counts {
  std::uint64_t patches = 0, cubics = 0;
  double worst = 0;  // of those that were not halved any further
};

Vec3d at(const core::Patch& patch, double u, double v) {
  const core::PatchJet jet = core::evaluate(patch, u, v);
  return {jet.point[0], jet.point[1], jet.point[2]};
}

// The value at t of the cubic with the values f at 0, 1/3, 2/3 and 1.
Vec3d cubic_at(const Vec3d (&f)[4], double t) {
  const double a = t, b = t - 1.0 / 3, c = t - 2.0 / 3, d = t - 1;
  return (-4.5 * b * c * d) * f[0] + (13.5 * a * c * d) * f[1] + (-13.5 * a * b * d) * f[2] +
         (4.5 * a * b * c) * f[3];
}

struct Off {
  double whole = 0, by_u = 0, by_v = 0;  // of both directions; of one where the other is kept
};

Off off_of(const core::Patch& patch, const Part& part) {
  const auto point = [&](double x, double y) {
    return at(patch, part.u0 + x * (part.u1 - part.u0), part.v0 + y * (part.v1 - part.v0));
  };
  Vec3d net[4][4];
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) net[i][j] = point(i / 3.0, j / 3.0);
  Off off;
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j) {
      const double x = i / double{kSide}, y = j / double{kSide};
      const Vec3d there = point(x, y);
      Vec3d columns[4], by_u[4], by_v[4];
      for (int k = 0; k < 4; ++k) {
        columns[k] = cubic_at(net[k], y);
        by_u[k] = point(k / 3.0, y);
        by_v[k] = point(x, k / 3.0);
      }
      off.whole = std::max(off.whole, length(cubic_at(columns, x) - there));
      off.by_u = std::max(off.by_u, length(cubic_at(by_u, x) - there));
      off.by_v = std::max(off.by_v, length(cubic_at(by_v, y) - there));
    }
  }
  return off;
}

// Recursion: 2 kHalvingsMax deep at most.
void reduce(const core::Patch& patch, const Part& part, double tolerance, Counts& counts) {
  const Off off = off_of(patch, part);
  const bool may_u = part.halvings_u < kHalvingsMax, may_v = part.halvings_v < kHalvingsMax;
  if (off.whole <= tolerance || (!may_u && !may_v)) {
    ++counts.cubics;
    counts.worst = std::max(counts.worst, off.whole);
    return;
  }
  const bool is_u = may_u && (off.by_u >= off.by_v || !may_v);
  Part low = part, high = part;
  if (is_u) {
    low.u1 = high.u0 = 0.5 * (part.u0 + part.u1);
    ++low.halvings_u, ++high.halvings_u;
  } else {
    low.v1 = high.v0 = 0.5 * (part.v0 + part.v1);
    ++low.halvings_v, ++high.halvings_v;
  }
  reduce(patch, low, tolerance, counts);
  reduce(patch, high, tolerance, counts);
}

double diagonal_of(const Scene& scene) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  Vec3f low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  for (const auto& surface : scene.surfaces) {
    for (PatchCursor cursor(*surface); cursor.is_any(); cursor.advance()) {
      for (std::size_t i = 0; i < cursor.form().point_count(); ++i) {
        const Vec3f p = cursor.point(i);
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
      }
    }
  }
  return double{length(high - low)};
}

Status measure(const std::string& path) {
  const auto read = import::cad::read_cad(path);
  if (!read.is_ok()) return read.status();
  const double diagonal = diagonal_of(read->scene);
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6}) {
    Counts counts;
    for (const auto& surface : read->scene.surfaces) {
      for (PatchCursor cursor(*surface); cursor.is_any(); cursor.advance()) {
        const PatchForm& form = cursor.form();
        const auto numbers =
            std::span(surface->numbers).subspan(cursor.first_number(), form.number_count());
        const auto checked =
            core::checked_patch({form.degree_u, form.degree_v, form.is_rational != 0, numbers});
        if (!checked.is_ok()) continue;
        ++counts.patches;
        reduce(checked->patch(), Part{}, tolerance * diagonal, counts);
      }
    }
    JsonObject json;
    json.add("file", path.substr(path.find_last_of('/') + 1)).add("tolerance", tolerance);
    json.add("patches", counts.patches).add("bicubics", counts.cubics);
    json.add("off", counts.worst / diagonal);
    std::printf("%s\n", json.text().c_str());
    std::fflush(stdout);
  }
  return Status::ok();
}

}  // namespace
}  // namespace tessera::bench

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const tessera::Status status = tessera::bench::measure(argv[i]);
    if (status.is_ok()) continue;
    std::fprintf(stderr, "cad_cubics: %s\n", status.message().c_str());
    return 1;
  }
  return 0;
}
