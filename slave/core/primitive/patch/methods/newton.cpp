// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/methods/newton.h"

#include "slave/core/primitive/patch/methods/newton_step.h"

namespace tessera::core {

namespace {

template <class Shape>
int iterate(const NewtonHow& how, const Shape& shape, const Patch& patch, const RaySight& sight,
            NearestRoot& to) {
  RayNet<Shape> net;
  const double flat = net.look(shape, patch, sight).flat;
  if (net.is_elsewhere(shape, flat)) return 0;
  const PartSides sides(to.range());
  const double room[2] = {2 * to.range().half_u, 2 * to.range().half_v};
  const double longest = 0x1p-14 / std::max(shape.m(), shape.n());
  double at[2] = {to.range().middle_u, to.range().middle_v};
  double before = std::numeric_limits<double>::infinity();
  bool is_there = false;
  int step = 0;
  for (; step < how.steps_max && !is_there; ++step) {
    const NetJet jet = jet_of(shape, net, at[0], at[1]);
    const double away = jet.size();
    if (!(away <= before)) return step;  // farther, or no number
    before = away;
    double by[2] = {};
    if (!newton_step(jet, by)) return step;
    is_there = away <= flat;
    // A longer step from a root may lead away from it again, where derivatives are nearly along
    // each other: second ones are up to 2 d^2 of the patch's size.
    if (is_there && std::max(std::fabs(by[0]), std::fabs(by[1])) > longest) break;
    for (int a = 0; a < 2; ++a) {
      at[a] += by[a];
      if (!(at[a] >= sides.low[a] - room[a] && at[a] <= sides.high[a] + room[a])) return step;
    }
  }
  bool is_inside = is_there;
  for (int a = 0; a < 2; ++a) is_inside &= at[a] >= sides.low[a] && at[a] <= sides.high[a];
  if (is_inside) to.add(at[0], at[1]);
  return step;
}

}  // namespace

int newton_roots(const NewtonHow& how, const Patch& patch, const SubPatch&, const RaySight& sight,
                 NearestRoot& to) {
  int steps = 0;
  by_degrees(patch, [&]<class Shape>(const Shape& shape) {
    steps = iterate(how, shape, patch, sight, to);
  });
  return steps;
}

}  // namespace tessera::core
