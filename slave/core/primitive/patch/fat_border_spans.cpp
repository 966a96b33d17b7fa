// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/fat_border_spans.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/patch_input.h"
#include "slave/core/primitive/patch/segment_bend.h"
#include "slave/core/primitive/patch/trim_part.h"

namespace tessera::core {
namespace {

constexpr double kUncertain = 5 * 0x1p-24;  // of the square: 4.5 u, and room for roundings
constexpr int kSpanDepthMax = 8;            // halvings of a segment
constexpr double kStraight = 1.0 / 4;       // of its chord: a span that is so near to it is short

class SegmentSplitter {
 public:
  SegmentSplitter(const Patch& patch, double longest, std::vector<FatSpan>& to)
      : patch_(patch), bend_(patch), longest_(longest), to_(to) {
    take_points(patch, points_);
  }

  void split(const FatSegment& segment, const TrimCoefficient* coefficients) {
    const int degree = static_cast<int>(segment.degree);
    TrimPart whole;
    int choices = 1;
    for (int i = 0; i <= degree; ++i) {
      const TrimCoefficient& c = coefficients[i];
      whole.net[i] = {c.u / choices, c.v / choices, c.w / choices};
      choices = choices * (degree - i) / (i + 1);
    }
    std::vector<TrimPart> parts{whole};
    while (!parts.empty()) {
      TrimPart& part = parts.back();
      if (add(part, segment, coefficients)) {
        parts.pop_back();
      } else {
        const TrimPart half = first_half(part, degree);
        parts.push_back(half);
      }
    }
  }

 private:
  PatchJet jet_at(const TrimCoefficient* coefficients, int degree, TrimParameter at) const {
    const TrimPlace place = point_at(coefficients, degree, at);
    return evaluate(patch_, points_, place.u, place.v);
  }

  // Of the whole, by what its halves are away from their own chords: second derivatives by the
  // whole's parameter are four times theirs. Bounds over halves are nearer to what they bound.
  double away_by_halves(TrimPart part, int degree) const {
    const TrimPart half = first_half(part, degree);
    return 4 * std::max(bend_.away_from_chord(half, degree), bend_.away_from_chord(part, degree));
  }

  // Returns: whether the part is a span already.
  bool add(const TrimPart& part, const FatSegment& segment, const TrimCoefficient* coefficients) {
    const int degree = static_cast<int>(segment.degree);
    const bool is_last = part.depth >= kSpanDepthMax;
    double size_u = 0, size_v = 0;
    Vec3d ends[3];
    const TrimParameter at[3] = {part.from, middle(part.from, part.to), part.to};
    for (int k = 0; k < 3; ++k) {
      const PatchJet jet = jet_at(coefficients, degree, at[k]);
      ends[k] = {jet.point[0], jet.point[1], jet.point[2]};
      size_u = std::max(size_u, length(Vec3d{jet.du[0], jet.du[1], jet.du[2]}));
      size_v = std::max(size_v, length(Vec3d{jet.dv[0], jet.dv[1], jet.dv[2]}));
    }
    const double width = double{segment.width} + kUncertain * (size_u + size_v);
    const double chord = length(ends[2] - ends[0]);
    const double most = std::max(width, kStraight * chord);
    double away = bend_.away_from_chord(part, degree);
    if (away > most) away = std::min(away, away_by_halves(part, degree));
    if (!is_last && (chord > longest_ || !(away <= most))) return false;
    const auto up = [](double x) {
      return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
    };
    // Nothing is known of a span with bounds beyond float32: it is left out.
    if (!std::isfinite(up(away)) || !std::isfinite(up(width))) return true;
    to_.push_back({part.from.t, part.to.t, up(width), up(away), segment.first, segment.degree});
    return true;
  }

  const Patch patch_;
  PatchPoint points_[kPatchPointsMax];
  const SegmentBend bend_;
  const double longest_;
  std::vector<FatSpan>& to_;
};

}  // namespace

FatBorders::FatBorders(const PatchSurface& surface, std::span<const FatSegment> segments,
                       const std::vector<TrimCoefficient>& coefficients, double span_share) {
  if (segments.empty()) return;
  std::size_t next = 0;
  for (PatchCursor at(surface); at.is_any(); at.advance()) {
    first_.push_back(static_cast<std::uint32_t>(spans_.size()));
    if (next == segments.size() || segments[next].patch != at.patch()) continue;
    const std::size_t first = next;
    while (next < segments.size() && segments[next].patch == at.patch()) ++next;
    const PatchForm& form = at.form();
    const auto numbers = std::span(surface.numbers).subspan(at.first_number(), form.number_count());
    const auto checked =
        checked_patch({form.degree_u, form.degree_v, form.is_rational != 0, numbers});
    if (!checked.is_ok()) continue;
    const auto splitter =
        std::make_unique<SegmentSplitter>(checked->patch(), span_share * checked->extent, spans_);
    for (const FatSegment& segment : segments.subspan(first, next - first))
      splitter->split(segment, coefficients.data() + segment.first);
  }
  first_.push_back(static_cast<std::uint32_t>(spans_.size()));
  spans_.shrink_to_fit();
}

}  // namespace tessera::core
