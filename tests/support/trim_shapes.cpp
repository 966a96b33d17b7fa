// SPDX-License-Identifier: Apache-2.0
#include "tests/support/trim_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

float within(float x) { return std::clamp(x, 0.0f, 1.0f); }

// A closed curve around a place: segments of random degrees through points at random distances.
void add_blob(PatchSurface& surface, Choices& choices, float u, float v, float radius,
              int degree_min, int degree_max, float weight_power) {
  std::vector<int> degrees;
  int count = 0;
  const unsigned segments = 1 + choices.below(4);
  for (unsigned s = 0; s < segments; ++s) {
    const auto span = static_cast<unsigned>(degree_max - degree_min + 1);
    degrees.push_back(degree_min + static_cast<int>(choices.below(span)));
    count += degrees.back();
  }
  std::vector<TrimPoint> points;
  for (int i = 0; i < count; ++i) {
    const float angle = 2 * kPi * static_cast<float>(i) / static_cast<float>(count);
    const float r = radius * (0.2f + 0.8f * choices.share());
    points.push_back({within(u + r * std::cos(angle)), within(v + r * std::sin(angle)),
                      choices.power(-weight_power, weight_power)});
  }
  add_loop(surface, points, degrees);
}

// A multiple of 1/16.
float grid(Choices& choices) { return static_cast<float>(choices.below(17)) / 16; }

void add_spike(PatchSurface& surface, Choices& choices) {
  const float u = 0.2f + 0.6f * choices.share(), v = 0.2f + 0.6f * choices.share();
  const float angle = 2 * kPi * choices.share(), a = 0.05f + 0.1f * choices.share();
  const auto at = [&](float x, float y) {
    return TrimPoint{within(u + x * std::cos(angle) - y * std::sin(angle)),
                     within(v + x * std::sin(angle) + y * std::cos(angle)), 1};
  };
  if (choices.one_in(2)) {
    // A cubic whose arms cross in a cusp, closed by a line below.
    add_loop(surface, {at(-a, 0), at(a, a), at(-a, a), at(a, 0)}, {3, 1});
  } else {
    // Two arcs that meet tangentially in a spike.
    add_loop(surface, {at(0, 0), at(0, a), at(a, 2 * a), at(0, a * choices.share())}, {2, 2});
  }
}

void add_touching(PatchSurface& surface, Choices& choices) {
  const float r = (1 + static_cast<float>(choices.below(3))) / 32, v = 0.5f;
  for (int i = 0; i < 4; ++i) {
    const float u = 0.25f + 2 * r * static_cast<float>(i);
    add_circle(surface, u, v, r);
    add_rectangle(surface, u - r, v + r, u + r, v + 2 * r);
  }
  add_circle(surface, 0.25f, v - 2 * r, r);      // from below
  add_circle(surface, 0.25f, v - r / 2, r / 2);  // from within
}

void add_strip(PatchSurface& surface, Choices& choices) {
  const float width = choices.power(-5.5f, -3);
  const float u = 0.1f + 0.8f * choices.share(), v = 0.1f + 0.8f * choices.share();
  if (choices.one_in(3)) {
    add_rectangle(surface, u, 0.05f, u + width, 0.95f);
  } else if (choices.one_in(2)) {
    add_rectangle(surface, 0.05f, v, 0.95f, v + width);
  } else {
    const float bend = 0.1f * choices.sign();
    add_loop(surface,
             {{0.05f, 0.1f},
              {u, v},
              {0.9f, 0.8f + bend},
              {0.9f, 0.8f + bend + width},
              {u, v + width},
              {0.05f, 0.1f + width}},
             {2, 1, 2, 1});
  }
}

void add_at_border(PatchSurface& surface, Choices& choices) {
  const float a = choices.share(), b = choices.share(), d = 0.3f * choices.share() + 0.01f;
  switch (choices.below(4)) {
    case 0:
      add_rectangle(surface, 0, 0, 1, 1);
      break;
    case 1:
      add_rectangle(surface, 1 - d, std::min(a, b), 1, std::max(a, b));
      break;
    case 2:
      add_loop(surface, {{a, 0}, {a * b, 0}, {0, 0}, {0, d}, {0, b}, {d, b}, {d, 0.1f}},
               {2, 1, 2, 1, 1});
      break;
    default:
      add_loop(surface, {{a, 1}, {1, 1}, {1, b}, {0.9f, b}, {a, b}}, {2, 1, 2});
  }
}

// Rings about nearly one place, or slanted strips, some of which cross the others.
void add_crowd(PatchSurface& surface, Choices& choices) {
  const bool are_rings = choices.one_in(2), falls = choices.one_in(2);
  const float apart = choices.one_in(2) ? 0 : choices.power(-5, -2);
  for (int i = 0; i < 60; ++i) {
    const float at = (static_cast<float>(i) + 0.5f) / 60, off = apart * choices.sign();
    if (are_rings) {
      add_circle(surface, 0.5f + off, 0.5f, 0.45f * at + 0.01f);
      continue;
    }
    const float a = 0.05f + 0.3f * at, b = falls ? 0.7f - a : a, to = falls ? -0.5f : 0.5f;
    const float from = falls ? 0.3f : 0, width = 0.0005f;
    add_loop(surface,
             {{a, b + from},
              {a + 0.3f + off, b + from + to * 0.4f},
              {a + 0.5f, b + from + to},
              {a + 0.5f, b + from + to + width},
              {a, b + from + width}},
             {2, 1, 1, 1});
  }
}

}  // namespace

PatchSurface plain_patch(bool keeps_outside) {
  PatchSurface surface;
  PatchForm form{1, 1, 0, 0};
  form.keeps_outside = keeps_outside ? 1 : 0;
  surface.patches = {form};
  surface.numbers = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0};
  surface.materials = {0};
  surface.loop_counts = {0};
  return surface;
}

void add_loop(PatchSurface& surface, const std::vector<TrimPoint>& points,
              const std::vector<int>& degrees) {
  ++surface.loop_counts.back();
  surface.segment_counts.push_back(static_cast<std::uint32_t>(degrees.size()));
  for (const int degree : degrees) surface.degrees.push_back(static_cast<std::uint8_t>(degree));
  surface.trim_points.insert(surface.trim_points.end(), points.begin(), points.end());
}

void add_circle(PatchSurface& surface, float u, float v, float radius) {
  const float w = std::sqrt(0.5f), r = radius;
  add_loop(surface,
           {{u + r, v},
            {u + r, v + r, w},
            {u, v + r},
            {u - r, v + r, w},
            {u - r, v},
            {u - r, v - r, w},
            {u, v - r},
            {u + r, v - r, w}},
           {2, 2, 2, 2});
}

void add_rectangle(PatchSurface& surface, float u0, float v0, float u1, float v1) {
  add_loop(surface, {{u0, v0}, {u1, v0}, {u1, v1}, {u0, v1}}, {1, 1, 1, 1});
}

TrimShapes::TrimShapes(TrimClass kind, Choices& choices)
    : choices_(choices), surface_(plain_patch(choices.one_in(2))) {
  PatchSurface& s = surface_;
  const auto anywhere = [&] { return 0.1f + 0.8f * choices.share(); };
  const unsigned some = 1 + choices.below(6);
  for (unsigned i = 0; i < some; ++i) {
    switch (kind) {
      case TrimClass::kSmooth:
        add_blob(s, choices, anywhere(), anywhere(), 0.3f, 2, 5, 0.5f);
        break;
      case TrimClass::kLevel: {
        std::vector<TrimPoint> points;
        for (int k = 0; k < 12; ++k) points.push_back({grid(choices), grid(choices)});
        add_loop(s, points, {1, 2, 3, 1, 2, 2, 1});
        break;
      }
      case TrimClass::kCusps:
        add_spike(s, choices);
        break;
      case TrimClass::kTouching:
        if (i == 0) add_touching(s, choices);
        break;
      case TrimClass::kTiny:
        for (int k = 0; k < 8; ++k) add_blob(s, choices, anywhere(), anywhere(), 5e-6f, 2, 4, 0.3f);
        add_circle(s, anywhere(), anywhere(), 5e-6f);
        break;
      case TrimClass::kNested:
        for (unsigned k = 0; k < 4; ++k)
          add_circle(s, 0.5f, 0.5f, 0.49f * static_cast<float>(4 * i + k + 1) / 24);
        break;
      case TrimClass::kBorder:
        add_at_border(s, choices);
        break;
      case TrimClass::kStrips:
        add_strip(s, choices);
        break;
      case TrimClass::kMany:
        for (int k = 0; k < 60; ++k)
          add_blob(s, choices, anywhere(), anywhere(), 0.02f, 1, 3, 0.2f);
        break;
      case TrimClass::kDegrees:
        add_blob(s, choices, anywhere(), anywhere(), 0.4f, 6, 15, 0.5f);
        break;
      case TrimClass::kWeights:
        add_blob(s, choices, anywhere(), anywhere(), 0.4f, 2, 7, 12);
        break;
      case TrimClass::kWildWeights:
        add_blob(s, choices, anywhere(), anywhere(), 0.4f, 2, 4, 37);
        break;
      case TrimClass::kCrossing:
        add_blob(s, choices, 0.5f, 0.5f, 0.5f, 2, 4, 0.5f);
        add_rectangle(s, grid(choices), grid(choices), grid(choices), grid(choices));
        break;
      case TrimClass::kCrowd:
        if (i == 0) add_crowd(s, choices);
        break;
    }
  }
}

TrimAsk TrimShapes::ask() {
  const auto anywhere = [&] { return double{choices_.share()}; };
  const auto inside = [](double x) { return std::clamp(x, 0.0, 1.0); };
  const TrimPoint& level =
      surface_.trim_points[choices_.below(static_cast<unsigned>(surface_.trim_points.size()))];
  switch (choices_.below(8)) {
    case 0:
      return {anywhere(), anywhere()};
    case 1:
      return {anywhere(), level.v};
    case 2:
      return {inside(level.u + std::ldexp(choices_.sign(), -static_cast<int>(choices_.below(20)))),
              inside(level.v + std::ldexp(choices_.sign(), -30))};
    default:
      break;
  }
  const TrimAsk on = on_loop();
  // Every other one is within some 4 u.
  const int power = choices_.one_in(2) ? 20 : 2 + static_cast<int>(choices_.below(20));
  const double angle = 2 * std::numbers::pi * anywhere();
  const double distance = std::ldexp(anywhere() + 0.1, -power);
  return {inside(on.u + distance * std::cos(angle)), inside(on.v + distance * std::sin(angle))};
}

TrimAsk TrimShapes::on_loop() {
  const auto count = static_cast<unsigned>(surface_.degrees.size());
  const unsigned chosen = choices_.below(count);
  std::size_t first = 0, loop = 0, loop_first = 0, in_loop = 0;
  for (unsigned s = 0; s < chosen; ++s) {
    first += surface_.degrees[s];
    if (++in_loop < surface_.segment_counts[loop]) continue;
    ++loop;
    in_loop = 0;
    loop_first = first;
  }
  const std::size_t degree = surface_.degrees[chosen];
  const bool closes = in_loop + 1 == surface_.segment_counts[loop];
  struct Point {
    double u, v, w;
  };
  std::vector<Point> net;
  for (std::size_t i = 0; i <= degree; ++i) {
    const TrimPoint& p = surface_.trim_points[closes && i == degree ? loop_first : first + i];
    const double w = p.weight;
    net.push_back({w * double{p.u}, w * double{p.v}, w});
  }
  // Ends are places of their own; where weights differ much, most of the curve is close to one.
  double t = choices_.share();
  if (choices_.one_in(3)) t = std::ldexp(t, -static_cast<int>(choices_.below(30)));
  if (choices_.one_in(2)) t = 1 - t;
  for (std::size_t k = degree; k > 0; --k)
    for (std::size_t i = 0; i < k; ++i)
      net[i] = {(1 - t) * net[i].u + t * net[i + 1].u, (1 - t) * net[i].v + t * net[i + 1].v,
                (1 - t) * net[i].w + t * net[i + 1].w};
  return {net[0].u / net[0].w, net[0].v / net[0].w};
}

}  // namespace tessera::test
