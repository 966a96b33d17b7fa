// SPDX-License-Identifier: Apache-2.0
// Writes metrics as a page of text, in the exposition format 0.0.4 that Prometheus scrapes
// (https://prometheus.io/docs/instrumenting/exposition_formats/).
//
// Threads. Plain value, one thread at a time.
//
// Invariants. (1) Every sample stands below the family that was begun last. (2) A family is begun
// once. (3) Label values may hold any byte; names may not, and a wrong one is a bug.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "common/metrics/cells.h"

namespace tessera::metrics {

inline constexpr std::string_view kContentType = "text/plain; version=0.0.4; charset=utf-8";

enum class Kind { kCounter, kGauge, kHistogram };

struct Label {
  std::string_view key, value;
};
using Labels = std::initializer_list<Label>;

class Exposition {
 public:
  // Begins a family. Requires: name new, of [a-zA-Z_:][a-zA-Z0-9_:]*; a counter's ends in _total.
  Exposition& family(std::string_view name, Kind kind, std::string_view help);

  // A sample of the family that was begun last.
  Exposition& sample(Labels labels, std::uint64_t value);
  Exposition& sample(Labels labels, double value);
  Exposition& sample(std::uint64_t value) { return sample({}, value); }
  Exposition& sample(double value) { return sample({}, value); }
  // Requires: a family of kind kHistogram.
  Exposition& histogram(const Histogram& histogram);

  // Writes a family of one sample.
  Exposition& counter(std::string_view name, std::string_view help, std::uint64_t value) {
    return family(name, Kind::kCounter, help).sample(value);
  }
  Exposition& gauge(std::string_view name, std::string_view help, double value) {
    return family(name, Kind::kGauge, help).sample(value);
  }

  const std::string& text() const { return text_; }

 private:
  void begin_sample(std::string_view suffix, Labels labels);

  std::string text_;
  std::string name_;  // of the family
  std::set<std::string, std::less<>> names_;
};

// Adds memory, processor time and open descriptors of this process, under the names that Prometheus
// client libraries use. The values come from /proc/self; what is not there is left out.
void add_process(Exposition& page);

}  // namespace tessera::metrics
