// SPDX-License-Identifier: Apache-2.0
// Cells of metrics, which hot paths touch. An update is one relaxed atomic operation, in a
// Histogram two, without a lock or an allocation.
//
// Threads. Any thread may touch and read any cell at any time. Readers see each cell whole, but not
// two cells at one moment: a scrape is no transaction.
//
// Invariants. (1) A Counter never falls. (2) A Histogram's bounds are fixed when it is made; its
// buckets and its sum never fall.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/base/check.h"

namespace tessera::metrics {

class Counter {
 public:
  void add(std::uint64_t n = 1) { value_.fetch_add(n, std::memory_order_relaxed); }
  std::uint64_t value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

// A counter of a quantity that is no whole number, such as seconds. Negative amounts and NaN are
// left out, so that it never falls.
class Sum {
 public:
  void add(double amount) {
    if (amount > 0) value_.fetch_add(amount, std::memory_order_relaxed);
  }
  double value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<double> value_{0};
};

class Gauge {
 public:
  void set(double value) { value_.store(value, std::memory_order_relaxed); }
  double value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<double> value_{0};
};

// Counts observations in buckets of fixed bounds; the last bucket takes what is above all bounds.
class Histogram {
 public:
  static constexpr std::size_t kBoundsMax = 24;

  // Requires: 1..kBoundsMax bounds, rising. They outlive the histogram (a constexpr array).
  explicit Histogram(std::span<const double> bounds) : bounds_(bounds) {
    TESSERA_CHECK(!bounds.empty() && bounds.size() <= kBoundsMax);
    for (std::size_t i = 1; i < bounds.size(); ++i) TESSERA_CHECK(bounds[i - 1] < bounds[i]);
  }

  // A value equal to a bound belongs below it ("le"). NaN is not counted.
  void observe(double value) {
    if (value != value) return;
    std::size_t bucket = 0;
    while (bucket < bounds_.size() && value > bounds_[bucket]) ++bucket;
    counts_[bucket].fetch_add(1, std::memory_order_relaxed);
    sum_.fetch_add(value, std::memory_order_relaxed);
  }

  std::span<const double> bounds() const { return bounds_; }
  // Observations in bucket i alone, without those below it. Requires: i <= bounds().size().
  std::uint64_t count(std::size_t i) const { return counts_[i].load(std::memory_order_relaxed); }
  double sum() const { return sum_.load(std::memory_order_relaxed); }

 private:
  const std::span<const double> bounds_;
  std::array<std::atomic<std::uint64_t>, kBoundsMax + 1> counts_{};
  std::atomic<double> sum_{0};
};

// Bounds from 1 ms to 30 s, about three to a decade, for frames and tiles, the thesis's and
// today's.
inline constexpr std::array<double, 14> kSecondsBounds{
    0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0};

}  // namespace tessera::metrics
