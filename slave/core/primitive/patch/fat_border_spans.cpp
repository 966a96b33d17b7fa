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
#include "slave/core/primitive/patch/trim_piece.h"

namespace tessera::core {
namespace {

constexpr double kUncertain = 5 * 0x1p-24;  // of the square: 4.5 u, and room for roundings
constexpr double kStraight = 1.0 / 4;       // of its chord: a span that is so near to it is short
// Of its chord: a run that is so near to it, and without larger holes.
constexpr double kRunStraight = 1.0 / 4, kRunHole = 1.0 / 64;

class SegmentSplitter {
 public:
  // Appends spans of the patch to `to`, which has those of others already.
  SegmentSplitter(const Patch& patch, double longest, std::vector<FatSpan>& to)
      : patch_(patch), bend_(patch), longest_(longest), first_(to.size()), to_(to) {
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

  // Marks the spans of the patch that go on with a run. Returns: how many runs there are.
  std::size_t join(int run_max) {
    std::size_t count = 0, first = 0;
    for (std::size_t i = 0; first_ + i < to_.size(); ++i) {
      const bool goes_on = i > first && i - first < static_cast<std::size_t>(run_max);
      to_[first_ + i].is_joined = goes_on && is_run(first, i) ? 1 : 0;
      if (to_[first_ + i].is_joined != 0) continue;
      first = i;
      ++count;
    }
    return count;
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
    const bool is_last = part.depth >= kFatSpanDepthMax;
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
    const auto step = [](const TrimParameter& p) {
      return static_cast<std::uint16_t>(p.t * (1 << kFatSpanDepthMax));
    };
    FatSpan span{};
    span.width = up(width);
    span.away = up(away);
    span.first = segment.first & (kTrimCoefficientsMax - 1);
    span.degree = segment.degree & 15u;
    span.from_step = step(part.from);
    span.to_step = step(part.to);
    to_.push_back(span);
    for (const Vec3d& end : ends) places_.push_back(end);
    return true;
  }

  // Whether the spans [first, last] of this patch lie along a line, one behind the other.
  bool is_run(std::size_t first, std::size_t last) const {
    const auto places = std::span(places_).subspan(3 * first, 3 * (last - first + 1));
    const Vec3d chord = places.back() - places.front();
    const double size = length(chord), square = dot(chord, chord);
    if (!(square > 0)) return false;
    for (std::size_t i = 1; i < places.size(); ++i) {
      const Vec3d step = places[i] - places[i - 1], from_first = places[i] - places.front();
      const Vec3d beside = from_first - (dot(from_first, chord) / square) * chord;
      if (!(length(beside) <= kRunStraight * size)) return false;
      const bool is_hole = i % 3 == 0;
      if (is_hole ? !(length(step) <= kRunHole * size) : !(dot(step, chord) >= 0)) return false;
    }
    return true;
  }

  const Patch patch_;
  PatchPoint points_[kPatchPointsMax];
  const SegmentBend bend_;
  const double longest_;
  const std::size_t first_;  // of the patch's spans
  std::vector<FatSpan>& to_;
  std::vector<Vec3d> places_;  // of the patch's spans: the first one, that halfway, the last one
};

}  // namespace

FatBorders::FatBorders(const PatchSurface& surface, std::span<const FatSegment> segments,
                       const std::vector<TrimCoefficient>& coefficients,
                       const FatSplitting& splitting) {
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
    const auto splitter = std::make_unique<SegmentSplitter>(
        checked->patch(), splitting.span_share * checked->extent, spans_);
    for (const FatSegment& segment : segments.subspan(first, next - first))
      splitter->split(segment, coefficients.data() + segment.first);
    run_count_ += splitter->join(splitting.run_max);
  }
  first_.push_back(static_cast<std::uint32_t>(spans_.size()));
  spans_.shrink_to_fit();
}

}  // namespace tessera::core
