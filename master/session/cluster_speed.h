// SPDX-License-Identifier: Apache-2.0
// How many rays a second a cluster traces, as a function of a frame's rays. Small frames cost more
// for each ray, since rays of neighbouring pixels lie farther apart and the fixed cost of a frame
// counts. Pure.
//
// The rate is a curve over the logarithm of a frame's rays, straight between knots that lie a
// factor of 4 apart. A measure moves the two knots beside it, the more the nearer they are; a knot
// that was never measured has the value of the nearest one that was. A measure that is far off
// tells of another cluster or of another view, and moves the whole curve.
//
// Threads. One owner.
#pragma once

#include <array>
#include <cstddef>

namespace tessera {

class ClusterSpeed {
 public:
  // The rate expected of a frame of so many rays; 0 before anything was measured.
  double rays_per_second(double rays) const;

  // Requires: both are greater than 0. A frame of so many rays took so long.
  void measured(double rays, double frame_seconds);

  // Requires: both are greater than 0. A frame of so many rays took at least so long.
  void at_most(double rays, double seconds_so_far);

 private:
  static constexpr std::size_t kKnots = 24;  // the last one is of 2^46 rays
  struct Place {
    std::size_t knot = 0;  // the lower one of the two, at most kKnots - 2
    double share = 0;      // of the way to the upper one
  };
  static Place place(double rays);
  double logarithm(const Place& at) const;
  void learn(const Place& at, double error);
  void move(double by);
  std::size_t nearest_known(std::size_t knot) const;

  std::array<double, kKnots> logarithm_{};  // of rays per second
  std::array<bool, kKnots> is_known_{};
  bool has_measured_ = false;
};

}  // namespace tessera
