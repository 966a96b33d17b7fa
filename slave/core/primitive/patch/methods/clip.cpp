// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/methods/clip.h"

#include "slave/core/primitive/patch/methods/method_limits.h"
#include "slave/core/primitive/patch/methods/ray_net.h"

namespace tessera::core {
namespace {

struct Line {
  double x, y;
  double size() const { return std::sqrt(x * x + y * y); }
};

// Part of [0, 1] that may hold roots.
struct Kept {
  double from = 1, to = 0;
  void take(double x) {
    from = std::min(from, x);
    to = std::max(to, x);
  }
  bool is_empty() const { return !(from <= to); }
};

template <class Shape>
class Clipping {
 public:
  Clipping(const ClipHow& how, const Shape& shape, NearestRoot& to)
      : how_(how), shape_(shape), to_(to) {}

  int run(const Patch& patch, const RaySight& sight) {
    NetBox<Shape>& first = stack_[0];
    const NetScale scale = first.look_at_part(shape_, patch, sight, to_.range());
    flat_ = scale.flat;
    widening_ = scale.noise * how_.widening;
    depth_ = 1;
    int boxes = 0;
    for (; depth_ > 0 && boxes < kMethodBoxesMax; ++boxes) step();
    return boxes;
  }

 private:
  // Looks at the last box once.
  void step() {
    NetBox<Shape>& box = stack_[depth_ - 1];
    if (box.is_elsewhere(shape_, widening_)) return drop();
    if (box.is_within(shape_, flat_)) return accept(box);
    const bool is_short[2] = {box.width(0) < kMethodLeastWidth, box.width(1) < kMethodLeastWidth};
    if (is_short[0] && is_short[1]) return accept(box);
    // The longer side in space first, of those that are not as short as can be.
    const Line along[2] = {line(box, 0), line(box, 1)};
    const double size[2] = {along[0].size(), along[1].size()};
    int axis = size[0] >= size[1] ? 0 : 1;
    if (is_short[axis]) axis = 1 - axis;
    for (int turn = 0; turn < 2; ++turn, axis = 1 - axis) {
      if (is_short[axis]) continue;
      const Kept kept = clipped(box, along, size, axis);
      if (kept.is_empty()) return drop();
      if (kept.to - kept.from > how_.halves_above) continue;
      return box.keep(shape_, axis, kept.from, kept.to);
    }
    halve(is_short[0]                  ? 1
          : is_short[1]                ? 0
          : size[0] > 0 || size[1] > 0 ? (size[0] >= size[1] ? 0 : 1)
                                       : (box.width(0) >= box.width(1) ? 0 : 1));
  }

  // Where the net goes along a parameter: the mean of two borders.
  Line line(const NetBox<Shape>& box, int axis) const {
    const int last = shape_.count() - 1, n = shape_.n(), side = last - n;
    const auto sum = [&](const double* f) {
      return axis == 0 ? f[side] - f[0] + f[last] - f[n] : f[n] - f[0] + f[last] - f[side];
    };
    return {sum(box.f[0]), sum(box.f[1])};
  }

  // What is left of a side by the distance from the line along the other one. Where both lines are
  // nearly one, that distance hardly moves, and the one along them is looked at as well.
  Kept clipped(const NetBox<Shape>& box, const Line (&along)[2], const double (&size)[2],
               int axis) const {
    const Line own = along[axis], other = along[1 - axis];
    Kept kept{0, 1};
    if (size[1 - axis] > 0) {
      kept = clipped(box, axis, {-other.y / size[1 - axis], other.x / size[1 - axis]});
      const double cross = std::fabs(own.x * other.y - own.y * other.x);
      if (cross > how_.line_sine * size[0] * size[1] || kept.is_empty()) return kept;
    }
    if (!(size[axis] > 0)) return kept;
    const Kept more = clipped(box, axis, {own.x / size[axis], own.y / size[axis]});
    return {std::max(kept.from, more.from), std::min(kept.to, more.to)};
  }

  // Where the convex hull of the distances meets 0, by the parameter.
  Kept clipped(const NetBox<Shape>& box, int axis, Line normal) const {
    constexpr int kMost = std::max(Shape::kDegreeU, Shape::kDegreeV);
    constexpr int kCount = kMost != 0 ? kMost + 1 : kPatchDegreeMax + 1;
    const int degree = axis == 0 ? shape_.m() : shape_.n();
    const int stride = shape_.n() + 1, step = axis == 0 ? stride : 1,
              across = axis == 0 ? 1 : stride;
    const int lines = axis == 0 ? stride : shape_.m() + 1;
    double low[kCount], high[kCount];
    for (int i = 0; i <= degree; ++i) {
      double least = 0, most = 0;
      for (int j = 0; j < lines; ++j) {
        const int at = step * i + across * j;
        const double d = normal.x * box.f[0][at] + normal.y * box.f[1][at];
        least = j == 0 ? d : std::min(least, d);
        most = j == 0 ? d : std::max(most, d);
      }
      low[i] = least - widening_;
      high[i] = most + widening_;
    }
    Kept kept;
    const double unit = 1.0 / degree;
    for (int i = 0; i <= degree; ++i) {
      if (low[i] <= 0 && high[i] >= 0) kept.take(i * unit);
      for (int k = 0; k <= degree; ++k) {
        if (!(low[i] > 0 && high[k] < 0) && !(low[i] > 0 && low[k] < 0) &&
            !(high[i] > 0 && high[k] < 0))
          continue;
        // Segments from above the axis to below it, of the lower and of the upper points.
        if (low[i] > 0 && low[k] < 0)
          kept.take((i + (k - i) * (low[i] / (low[i] - low[k]))) * unit);
        if (high[i] > 0 && high[k] < 0)
          kept.take((i + (k - i) * (high[i] / (high[i] - high[k]))) * unit);
      }
    }
    return kept;
  }

  void halve(int axis) {
    if (depth_ == kMethodStackMax) return drop();
    NetBox<Shape>& box = stack_[depth_ - 1];
    stack_[depth_] = box;
    box.keep(shape_, axis, 0.5, 1);
    stack_[depth_++].keep(shape_, axis, 0, 0.5);
  }
  void accept(const NetBox<Shape>& box) {
    to_.add(box.middle(0), box.middle(1));
    drop();
  }
  void drop() { --depth_; }

  const ClipHow& how_;
  const Shape shape_;
  NearestRoot& to_;
  double flat_ = 0, widening_ = 0;
  int depth_ = 0;
  NetBox<Shape> stack_[kMethodStackMax];
};

}  // namespace

int clip_roots(const ClipHow& how, const Patch& patch, const SubPatch&, const RaySight& sight,
               NearestRoot& to) {
  int boxes = 0;
  by_degrees(patch, [&]<class Shape>(const Shape& shape) {
    boxes = Clipping<Shape>(how, shape, to).run(patch, sight);
  });
  return boxes;
}

}  // namespace tessera::core
