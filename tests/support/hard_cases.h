// SPDX-License-Identifier: Apache-2.0
// The classes of rays and triangles that ray tracers go wrong at, each with a printed seed: for the
// property test and for the report of tessera-bench.
//
// Threads. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "tests/support/reference_tracer.h"

namespace tessera::test {

struct HardCase {
  std::string name;
  Mesh mesh;
  std::vector<Ray> rays;
  bool is_closed = false;    // every ray starts inside: a miss is a leak
  bool has_invalid = false;  // some rays are not valid
};

std::vector<std::string> hard_case_names();
// Requires: one of the names.
HardCase make_hard_case(const std::string& name, std::size_t ray_count, std::uint32_t seed);

// What is wrong with answers, and how far t and u, v are off.
struct Verdicts {
  std::size_t rays = 0, missed = 0, wrong = 0, false_hits = 0, leaks = 0, invalid = 0;
  // Errors of hits that are not at an edge: relative error of t; error of t over u s / (|D| cos);
  // largest error of u, v.
  std::vector<double> t_relative, t_normed, uv;
  std::string worst_ray;  // that of the largest t_normed, in hexadecimal
  double worst = 0;

  std::size_t bad() const { return missed + wrong + false_hits + leaks + invalid; }
};

struct Answer {
  bool is_hit;
  std::uint32_t primitive;
  float t, u, v;
};

// Shape: answers [case.rays]. Looks at every triangle for every ray, in double.
Verdicts judge_all(const HardCase& hard, const std::vector<Answer>& answers);

}  // namespace tessera::test
