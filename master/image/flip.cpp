// SPDX-License-Identifier: Apache-2.0
#include "master/image/flip.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera::master {
namespace {

constexpr double kPi = 3.14159265358979;

using Colour = std::array<double, 3>;
using Plane = std::vector<double>;

struct Size {
  int width, height;
  std::size_t count() const { return static_cast<std::size_t>(width * height); }
};

// The white of D65 in XYZ.
constexpr Colour kWhite{0.950428545, 1.0, 1.088900371};

Colour xyz_of(const Colour& rgb) {
  const auto [r, g, b] = rgb;
  return {0.4124564 * r + 0.3575761 * g + 0.1804375 * b,
          0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
          0.0193339 * r + 0.1191920 * g + 0.9503041 * b};
}

Colour rgb_of(const Colour& xyz) {
  const auto [x, y, z] = xyz;
  return {3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
          -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
          0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
}

// Luminance and two opponent colours, linear, on which the eye's contrast sensitivity acts.
Colour opponent_of(const Colour& xyz) {
  const double x = xyz[0] / kWhite[0], y = xyz[1] / kWhite[1], z = xyz[2] / kWhite[2];
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Colour from_opponent(const Colour& o) {
  const double y = (o[0] + 16) / 116, x = y + o[1] / 500, z = y - o[2] / 200;
  return {x * kWhite[0], y * kWhite[1], z * kWhite[2]};
}

// CIELAB, colours weighed by lightness (Hunt effect).
Colour perceived(const Colour& rgb) {
  constexpr double kDelta = 6.0 / 29;
  const auto f = [](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const Colour xyz = xyz_of(rgb);
  const double x = f(xyz[0] / kWhite[0]), y = f(xyz[1] / kWhite[1]), z = f(xyz[2] / kWhite[2]);
  const double lightness = 116 * y - 16;
  return {lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)};
}

double colour_distance(const Colour& a, const Colour& b) {
  const double h = std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
  return std::pow(h, 0.7);
}

// The greatest distance, of pure green and pure blue, becomes 1; small ones get most of the range.
double redistributed(double distance) {
  static const double kMost = colour_distance(perceived({0, 1, 0}), perceived({0, 0, 1}));
  constexpr double kShare = 0.4, kBecomes = 0.95;
  const double border = kShare * kMost;
  if (distance < border) return distance * kBecomes / border;
  return kBecomes + (distance - border) / (kMost - border) * (1 - kBecomes);
}

// Convolves rows with `across`, then columns with `down`; the border is repeated.
// Requires: both kernels have odd sizes.
Plane convolved(const Plane& from, Size size, const std::vector<double>& across,
                const std::vector<double>& down) {
  const auto pass = [&](const Plane& in, const std::vector<double>& kernel, bool is_across) {
    Plane out(in.size());
    const int radius = static_cast<int>(kernel.size() / 2);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        double sum = 0;
        for (int k = -radius; k <= radius; ++k) {
          const int at_x = is_across ? std::clamp(x + k, 0, size.width - 1) : x;
          const int at_y = is_across ? y : std::clamp(y + k, 0, size.height - 1);
          sum += kernel[static_cast<std::size_t>(k + radius)] *
                 in[static_cast<std::size_t>(at_y * size.width + at_x)];
        }
        out[static_cast<std::size_t>(y * size.width + x)] = sum;
      }
    }
    return out;
  };
  return pass(pass(from, across, true), down, false);
}

// exp(-distance^2 / (2 sigma^2)), sums to 1.
std::vector<double> bell(double sigma_px, int radius) {
  std::vector<double> kernel;
  double sum = 0;
  for (int k = -radius; k <= radius; ++k) {
    kernel.push_back(std::exp(-k * k / (2 * sigma_px * sigma_px)));
    sum += kernel.back();
  }
  for (double& x : kernel) x /= sum;
  return kernel;
}

// Contrast sensitivity as a sum of bells a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees.
Plane as_seen(const Plane& from, Size size, double a1, double b1, double a2, double b2) {
  constexpr double kWidest = 0.04;
  const double per_degree = kFlipPixelsPerDegree;
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * per_degree));
  const auto sigma = [&](double b) { return std::sqrt(b / (2 * kPi * kPi)) * per_degree; };
  // The volume of a bell in pixels decides its share.
  const double v1 = a1 * std::sqrt(kPi / b1) * b1, v2 = a2 * std::sqrt(kPi / b2) * b2;
  const std::vector<double> first = bell(sigma(b1), radius);
  Plane out = convolved(from, size, first, first);
  if (v2 > 0) {
    const std::vector<double> second = bell(sigma(b2), radius);
    const Plane wide = convolved(from, size, second, second);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = (v1 * out[i] + v2 * wide[i]) / (v1 + v2);
  }
  return out;
}

// First (edges) or second (points) derivative of a bell; positive and negative weights sum to 1 and
// -1.
std::vector<double> detector(double sigma_px, int radius, bool is_point) {
  std::vector<double> kernel;
  double positive = 0, negative = 0;
  for (int k = -radius; k <= radius; ++k) {
    const double g = std::exp(-k * k / (2 * sigma_px * sigma_px));
    kernel.push_back(is_point ? (k * k / (sigma_px * sigma_px) - 1) * g : -k * g);
    (kernel.back() > 0 ? positive : negative) += kernel.back();
  }
  for (double& x : kernel) x /= x > 0 ? positive : -negative;
  return kernel;
}

struct Features {
  Plane edges, points;  // strength at each pixel
};

Features features_of(const Plane& luminance, Size size) {
  constexpr double kWidthDegrees = 0.082;
  const double sigma = 0.5 * kWidthDegrees * kFlipPixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const std::vector<double> smooth = bell(sigma, radius);
  const auto strength = [&](bool is_point) {
    const std::vector<double> find = detector(sigma, radius, is_point);
    Plane across = convolved(luminance, size, find, smooth);
    const Plane down = convolved(luminance, size, smooth, find);
    for (std::size_t i = 0; i < across.size(); ++i) across[i] = std::hypot(across[i], down[i]);
    return across;
  };
  return {strength(false), strength(true)};
}

struct Seen {
  std::vector<Colour> colours;
  Features features;
};

Seen seen(std::span<const float> rgb, Size size) {
  std::array<Plane, 3> opponent;
  Plane luminance(size.count());
  for (Plane& plane : opponent) plane.resize(size.count());
  for (std::size_t i = 0; i < size.count(); ++i) {
    Colour c;
    for (std::size_t k = 0; k < 3; ++k)
      c[k] = std::clamp(static_cast<double>(rgb[3 * i + k]), 0.0, 1.0);
    const Colour o = opponent_of(xyz_of(c));
    for (std::size_t k = 0; k < 3; ++k) opponent[k][i] = o[k];
    luminance[i] = (o[0] + 16) / 116;
  }
  const Plane a = as_seen(opponent[0], size, 1, 0.0047, 0, 1e-5);
  const Plane b = as_seen(opponent[1], size, 1, 0.0053, 0, 1e-5);
  const Plane c = as_seen(opponent[2], size, 34.1, 0.04, 13.5, 0.025);
  Seen result;
  for (std::size_t i = 0; i < size.count(); ++i) {
    Colour linear = rgb_of(from_opponent({a[i], b[i], c[i]}));
    for (double& x : linear) x = std::clamp(x, 0.0, 1.0);
    result.colours.push_back(perceived(linear));
  }
  result.features = features_of(luminance, size);
  return result;
}

}  // namespace

std::vector<float> flip_map(std::span<const float> image, std::span<const float> reference,
                            int width_px, int height_px) {
  const Size size{width_px, height_px};
  const Seen a = seen(image, size), b = seen(reference, size);
  std::vector<float> map(size.count());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const double colour = redistributed(colour_distance(a.colours[i], b.colours[i]));
    const double edges = std::abs(a.features.edges[i] - b.features.edges[i]);
    const double points = std::abs(a.features.points[i] - b.features.points[i]);
    const double feature = std::sqrt(std::max(edges, points) / std::sqrt(2.0));
    map[i] = static_cast<float>(std::pow(colour, 1 - std::min(1.0, feature)));
  }
  return map;
}

}  // namespace tessera::master
