// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/axis.h"

#include <cmath>

namespace tessera::import::cad {
namespace {

constexpr double kRelative = 1e-9;  // of an interval: parameters nearer than this are the same

}  // namespace

double Axis::local(std::size_t cell, double parameter) const {
  const double a = borders[cell], b = borders[cell + 1];
  const double near = kRelative * (b - a);
  if (std::fabs(parameter - a) <= near) return 0;
  if (std::fabs(parameter - b) <= near) return 1;
  if (!is_angle) return (parameter - a) / (b - a);
  return (1 + std::tan((parameter - (a + b) / 2) / 2) / std::tan((b - a) / 4)) / 2;
}

}  // namespace tessera::import::cad
