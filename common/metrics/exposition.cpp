// SPDX-License-Identifier: Apache-2.0
#include "common/metrics/exposition.h"

#include <charconv>
#include <cmath>

#include "common/base/check.h"

namespace tessera::metrics {
namespace {

bool is_name(std::string_view text) {
  if (text.empty() || (text[0] >= '0' && text[0] <= '9')) return false;
  for (const char c : text) {
    const bool is_good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                         (c >= '0' && c <= '9') || c == '_' || c == ':';
    if (!is_good) return false;
  }
  return true;
}

void append_escaped(std::string& out, std::string_view text, bool escapes_quotes) {
  for (const char c : text) {
    if (c == '\n') {
      out += "\\n";
    } else {
      if (c == '\\' || (c == '"' && escapes_quotes)) out.push_back('\\');
      out.push_back(c);
    }
  }
}

void append_number(std::string& out, double value) {
  if (std::isnan(value)) {
    out += "NaN";
  } else if (std::isinf(value)) {
    out += value > 0 ? "+Inf" : "-Inf";
  } else {
    char digits[32];
    out.append(digits, std::to_chars(digits, digits + sizeof(digits), value).ptr);
  }
}

const char* kind_text(Kind kind) {
  switch (kind) {
    case Kind::kCounter:
      return "counter";
    case Kind::kGauge:
      return "gauge";
    case Kind::kHistogram:
      return "histogram";
  }
  return "untyped";
}

}  // namespace

Exposition& Exposition::family(std::string_view name, Kind kind, std::string_view help) {
  TESSERA_CHECK(is_name(name));
  TESSERA_CHECK_EQ(kind == Kind::kCounter, name.ends_with("_total"));
  TESSERA_CHECK(names_.emplace(name).second);
  name_ = name;
  text_.append("# HELP ").append(name).append(" ");
  append_escaped(text_, help, false);
  text_.append("\n# TYPE ").append(name).append(" ").append(kind_text(kind)).append("\n");
  return *this;
}

void Exposition::begin_sample(std::string_view suffix, Labels labels) {
  TESSERA_CHECK(!name_.empty());
  text_.append(name_).append(suffix);
  char separator = '{';
  for (const Label& label : labels) {
    TESSERA_CHECK(is_name(label.key));
    text_.push_back(separator);
    text_.append(label.key).append("=\"");
    append_escaped(text_, label.value, true);
    text_.push_back('"');
    separator = ',';
  }
  if (separator == ',') text_.push_back('}');
  text_.push_back(' ');
}

Exposition& Exposition::sample(Labels labels, std::uint64_t value) {
  begin_sample("", labels);
  text_.append(std::to_string(value)).push_back('\n');
  return *this;
}

Exposition& Exposition::sample(Labels labels, double value) {
  begin_sample("", labels);
  append_number(text_, value);
  text_.push_back('\n');
  return *this;
}

Exposition& Exposition::histogram(const Histogram& histogram) {
  std::uint64_t count = 0;  // cumulative: the format's buckets hold what is below them, too
  for (std::size_t i = 0; i <= histogram.bounds().size(); ++i) {
    count += histogram.count(i);
    std::string bound;
    append_number(bound, i < histogram.bounds().size() ? histogram.bounds()[i] : INFINITY);
    begin_sample("_bucket", {{"le", bound}});
    text_.append(std::to_string(count)).push_back('\n');
  }
  begin_sample("_sum", {});
  append_number(text_, histogram.sum());
  text_.push_back('\n');
  begin_sample("_count", {});
  text_.append(std::to_string(count)).push_back('\n');
  return *this;
}

}  // namespace tessera::metrics
