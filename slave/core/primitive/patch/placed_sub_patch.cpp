// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/placed_sub_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/rounding.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/sub_patch_bounds.h"
#include "slave/core/primitive/patch/sub_patch_range.h"

namespace tessera::core {
namespace {

constexpr double kSums = 0x1p-48;  // roundings of sums of up to nine products, of their sizes
// D above which a frame is not taken along: it is 2^-53 times the condition of the frame.
constexpr double kInverseErrorMax = 0x1p-20;

float rounded_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

// Returns: false for a matrix without an inverse.
bool invert(const double (&m)[3][3], double (&inverse)[3][3]) {
  double determinant = 0;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      inverse[j][i] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
      if (i == 0) determinant += m[0][j] * inverse[j][0];
    }
  }
  if (!(std::fabs(determinant) > 0 && std::isfinite(determinant))) return false;
  for (auto& row : inverse)
    for (double& value : row) value /= determinant;
  return true;
}

}  // namespace

// What is known of the frames of a part before and after.
struct PatchPlacement::Frames {
  double edges[3][3];   // J: columns are the frame's directions in the patch's own place
  double world[3][3];   // M J
  double sizes[3][3];   // |M| |J|
  double growth[3][3];  // bounds of |G|
  double off = 0;       // |D|
};

PatchPlacement::PatchPlacement(const Transform& to_world) {
  double linear[3][3];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) m_[i][j] = double{to_world.m[i][j]};
    for (std::size_t j = 0; j < 3; ++j) linear[i][j] = m_[i][j];
  }
  is_regular_ = invert(linear, inverse_);
}

void PatchPlacement::take(const Patch& patch, const Bounds3f& placed_box) {
  double largest[3] = {}, least_weight = HUGE_VAL, most_weight = 0;
  const int count = (patch.degree_u + 1) * (patch.degree_v + 1);
  for (int k = 0; k < count; ++k) {
    const PatchPoint p = plain::point_of(patch, k);
    const double w = p.x[3];
    least_weight = std::min(least_weight, w);
    most_weight = std::max(most_weight, w);
    for (int a = 0; a < 3; ++a) largest[a] = std::max(largest[a], std::fabs(p.x[a] / w));
  }
  ratio_ = most_weight / least_weight;
  degree_ = std::max(patch.degree_u, patch.degree_v);
  for (int i = 0; i < 3; ++i) {
    double size = std::fabs(m_[i][3]);
    for (int j = 0; j < 3; ++j) size += std::fabs(m_[i][j]) * largest[j];
    off_[i] = 4.5 * double{kUnitRoundoff} * size + double{std::numeric_limits<float>::min()};
  }
  // Wider as the boxes of parts are, for the overlap of ranges.
  float lower[3], upper[3];
  for (int a = 0; a < 3; ++a) {
    const double wide =
        (double{placed_box.upper[a]} - double{placed_box.lower[a]}) * 0x1p-12 + off_[a];
    lower[a] = -rounded_up(-(double{placed_box.lower[a]} - wide));
    upper[a] = rounded_up(double{placed_box.upper[a]} + wide);
  }
  patch_box_ = {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

SubPatch PatchPlacement::placed(const SubPatch& part, Bounds3f& box) const {
  SubPatch to = part;
  box = placed_box(box);
  to.has_frame = false;
  if (!part.has_frame || !is_regular_) return to;
  Frames frames;
  double frame[3][3];
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k) frame[r][k] = double{part.frame[r][k]};
  if (!invert(frame, frames.edges)) return to;
  for (int r = 0; r < 3; ++r) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      double product = r == k ? -1 : 0, size = 0;
      frames.world[r][k] = frames.sizes[r][k] = 0;
      for (int j = 0; j < 3; ++j) {
        product += frame[r][j] * frames.edges[j][k];
        size += std::fabs(frame[r][j] * frames.edges[j][k]);
        frames.world[r][k] += m_[r][j] * frames.edges[j][k];
        frames.sizes[r][k] += std::fabs(m_[r][j] * frames.edges[j][k]);
      }
      sum += std::fabs(product) + kSums * (1 + size);
    }
    frames.off = std::max(frames.off, sum);
  }
  if (!(frames.off <= kInverseErrorMax)) return to;
  if (!place_frame(frames, to)) return to;
  widen(frames, part, to);
  cut_to_parallelepiped(frames, part, box);
  bool is_finite = true;
  for (int r = 0; r < 3; ++r) {
    is_finite = is_finite && std::isfinite(to.centre[r]) && std::isfinite(to.reach[r]);
    for (int k = 0; k < 3; ++k)
      is_finite = is_finite && std::isfinite(to.frame[r][k]) && std::isfinite(to.second[k][r]);
  }
  to.has_frame = is_finite;
  // Those that are infinite would be a border's (fat_border.h).
  if (!is_finite) std::copy_n(&part.second[0][0], 9, &to.second[0][0]);
  return to;
}

bool PatchPlacement::place_frame(const Frames& frames, SubPatch& to) const {
  // The rows of F M^-1, made from M J: the inverse of what it does to the frame's directions.
  double rows[3][3];
  if (!invert(frames.world, rows)) return false;
  for (int r = 0; r < 3; ++r) {
    double centre = m_[r][3];
    for (int k = 0; k < 3; ++k) {
      to.frame[r][k] = static_cast<float>(rows[r][k]);
      centre += m_[r][k] * double{to.centre[k]};
    }
    rows[r][0] = centre;  // no row is needed any more
  }
  for (int r = 0; r < 3; ++r) to.centre[r] = static_cast<float>(rows[r][0]);
  return true;
}

void PatchPlacement::widen(const Frames& frames, const SubPatch& part, SubPatch& to) const {
  const SubPatchRange range(part);
  const double half = std::max(range.half_u, range.half_v);
  const double bend = 24.0 * degree_ * degree_ * ratio_ * ratio_ * half * half * (1 + 16 * kBeyond);
  double moved[3];  // M c - c', and its roundings
  for (int a = 0; a < 3; ++a) {
    double sum = m_[a][3], size = std::fabs(m_[a][3]);
    for (int k = 0; k < 3; ++k) {
      sum += m_[a][k] * double{part.centre[k]};
      size += std::fabs(m_[a][k] * double{part.centre[k]});
    }
    moved[a] = std::fabs(sum - double{to.centre[a]}) + kSums * size;
  }
  for (int r = 0; r < 3; ++r) {
    double reach = double{part.reach[r]}, second[3];
    for (int k = 0; k < 3; ++k) second[k] = double{part.second[k][r]};
    for (int k = 0; k < 3; ++k) {
      double product = r == k ? -1 : 0, size = 0;
      for (int j = 0; j < 3; ++j) {
        product += double{to.frame[r][j]} * frames.world[j][k];
        size += std::fabs(double{to.frame[r][j]}) * frames.sizes[j][k];
      }
      const double growth = std::fabs(product) + size * (kSums + frames.off * (1 + 0x1p-10));
      const double local = (k < 2 ? 1 + kSquareWiden : 0) + double{part.reach[k]};
      const double row = std::fabs(double{to.frame[r][k]});
      reach += growth * local + row * (moved[k] + off_[k]);
      for (int d = 0; d < 3; ++d)
        second[d] += growth * double{part.second[d][k]} + row * off_[k] * bend;
    }
    to.reach[r] = rounded_up(reach * (1 + kBeyond));
    for (int d = 0; d < 3; ++d) to.second[d][r] = rounded_up(second[d] * (1 + kBeyond));
  }
}

// The box of a box, wider by the roundings of points; within that of the patch.
Bounds3f PatchPlacement::placed_box(const Bounds3f& box) const {
  float lower[3], upper[3];
  for (int a = 0; a < 3; ++a) {
    double low = m_[a][3], high = m_[a][3], size = std::fabs(m_[a][3]);
    for (int k = 0; k < 3; ++k) {
      const double from = m_[a][k] * double{box.lower[k]}, till = m_[a][k] * double{box.upper[k]};
      low += std::min(from, till);
      high += std::max(from, till);
      size += std::max(std::fabs(from), std::fabs(till));
    }
    const double wide = off_[a] + kSums * size;
    lower[a] = std::max(patch_box_.lower[a], -rounded_up(-(low - wide)));
    upper[a] = std::min(patch_box_.upper[a], rounded_up(high + wide));
  }
  return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

// The part also lies in the parallelepiped of its frame, which may be much less for a map that
// turns.
void PatchPlacement::cut_to_parallelepiped(const Frames& frames, const SubPatch& part,
                                           Bounds3f& box) const {
  float lower[3], upper[3];
  for (int a = 0; a < 3; ++a) {
    double centre = m_[a][3], away = 0, size = std::fabs(m_[a][3]);
    for (int k = 0; k < 3; ++k) {
      centre += m_[a][k] * double{part.centre[k]};
      size += std::fabs(m_[a][k] * double{part.centre[k]});
      const double local = (k < 2 ? 1 + kSquareWiden : 0) + double{part.reach[k]};
      away += (std::fabs(frames.world[a][k]) +
               frames.sizes[a][k] * (kSums + frames.off * (1 + 0x1p-10))) *
              local;
    }
    const double wide = away * (1 + kBeyond) + off_[a] + kSums * size;
    lower[a] = std::max(box.lower[a], -rounded_up(-(centre - wide)));
    upper[a] = std::min(box.upper[a], rounded_up(centre + wide));
  }
  box = {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

}  // namespace tessera::core
