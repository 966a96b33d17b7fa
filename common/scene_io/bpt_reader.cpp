// SPDX-License-Identifier: Apache-2.0
// Bezier patches as text, as the teapot has been handed on since 1975, with weights and loops.
//
//   number of patches, then for each patch
//   m n                           degrees, 1 to 15
//   x y z [w]                     (m+1)(n+1) lines; point (n+1)i+j; all have weights, or none
//   trim LOOPS in|out             optional: what the loops enclose is kept, or left out
//   loop SEGMENTS [DEGREE]        for each loop; degree 3 where none is said
//   u v [w]                       SEGMENTS times DEGREE lines: the points of each segment but its
//                                 last one, which is the next one's first
//
// '#' begins a comment.
#include <array>
#include <cmath>

#include "common/base/limits.h"
#include "common/scene_io/scene_reader.h"
#include "common/scene_io/text_scanner.h"

namespace tessera {
namespace {

constexpr std::uint64_t kFileBytesMax = std::uint64_t{4} << 30;
constexpr int kLoopDegree = 3;  // where a file says none

std::string text_of(std::uint64_t number) { return std::to_string(number); }

// The lines of a file that say something, as words.
class WordLines {
 public:
  explicit WordLines(std::string_view text) : scanner_(text) {}

  // Looks at the next line without passing it. Returns: false at the end.
  bool peek() {
    while (count_ == 0) {
      if (!scanner_.next_line()) return false;
      const std::string_view line = scanner_.line();
      TextScanner words(line.substr(0, line.find('#')));
      if (!words.next_line()) continue;
      for (std::string_view word = words.word(); !word.empty() && count_ < words_.size();
           word = words.word())
        words_[count_++] = word;
    }
    return true;
  }
  void pass() { count_ = 0; }

  // Of the line that was looked at. Words behind the fifth are left out, since no line has them.
  std::size_t count() const { return count_; }
  std::string_view word(std::size_t index) const {
    return index < count_ ? words_[index] : std::string_view();
  }
  template <typename T>
  std::optional<T> number(std::size_t index) const {
    return TextScanner::number_of<T>(word(index));
  }
  std::uint64_t line_number() const { return scanner_.line_number(); }

 private:
  TextScanner scanner_;
  std::array<std::string_view, 5> words_;
  std::size_t count_ = 0;
};

class BptReader {
 public:
  BptReader(std::string path, std::string_view text) : path_(std::move(path)), lines_(text) {}

  Result<ReadScene> read() {
    if (!lines_.peek()) return Status::invalid_argument(path_ + ": no patches");
    const auto count = lines_.number<std::uint64_t>(0);
    if (!count || lines_.count() != 1) return wrong("needs the number of patches, and no more");
    if (*count == 0) return Status::invalid_argument(path_ + ": no patches");
    if (*count > kPatchesMax) return Status::resource_exhausted(path_ + ": more than 2^24 patches");
    lines_.pass();
    while (surface_.patches.size() < *count) {
      if (!lines_.peek()) {
        return Status::invalid_argument(path_ + ": announces " + text_of(*count) +
                                        " patches, but only " + text_of(surface_.patches.size()) +
                                        " follow");
      }
      TESSERA_RETURN_IF_ERROR(read_patch());
    }
    if (lines_.peek())
      return wrong("something follows the last of " + text_of(*count) + " patches");
    if (!surface_.loop_counts.empty()) surface_.loop_counts.resize(surface_.patches.size(), 0);
    surface_.materials = {0};
    ReadScene result;
    result.scene.materials.emplace_back();
    result.scene.materials[0].name = "default";
    result.scene.surfaces = {std::make_shared<const PatchSurface>(std::move(surface_))};
    result.scene.instances = {{0, {}, ObjectKind::kPatchSurface}};
    return result;
  }

 private:
  Status wrong(const std::string& text) const {
    return Status::invalid_argument(path_ + ":" + text_of(lines_.line_number()) + ": " + text);
  }
  static std::optional<std::uint8_t> degree_of(std::optional<int> number) {
    if (!number || *number < 1 || *number > kPatchDegreesMax) return std::nullopt;
    return static_cast<std::uint8_t>(*number);
  }

  Status read_patch() {
    const std::string patch = "patch " + text_of(surface_.patches.size());
    const auto m = lines_.number<int>(0), n = lines_.number<int>(1);
    if (!m || !n || lines_.count() != 2) return wrong(patch + " needs a line of two degrees");
    const auto degree_u = degree_of(m), degree_v = degree_of(n);
    if (!degree_u || !degree_v) return wrong(patch + ": degrees must lie in 1 to 15");
    lines_.pass();
    PatchForm form{*degree_u, *degree_v, 0, 0};
    const std::size_t first = surface_.numbers.size();
    for (std::size_t i = 0; i < form.point_count(); ++i) {
      const bool is_there = lines_.peek();
      if (is_there && i == 0) form.is_rational = lines_.count() == 4 ? 1 : 0;
      TESSERA_RETURN_IF_ERROR(read_point(form, i, is_there, patch));
    }
    if (is_one_place(form, first)) return wrong(patch + ": all its points are in one place");
    surface_.patches.push_back(form);
    return lines_.peek() && lines_.word(0) == "trim" ? read_trim(patch) : Status::ok();
  }

  Status read_point(const PatchForm& form, std::size_t index, bool is_there,
                    const std::string& patch) {
    const auto point = [&] { return "point " + text_of(index) + " of " + patch; };
    if (!is_there) {
      return wrong("the file ends before " + point() + ", which has " +
                   text_of(form.point_count()));
    }
    const std::size_t count = form.is_rational != 0 ? 4 : 3;
    if (lines_.count() == 7 - count && lines_.number<float>(0))
      return wrong(point() + ": all points of a patch need weights, or none");
    if (lines_.count() != count)
      return wrong(point() + " needs three numbers, or four with a weight");
    for (std::size_t k = 0; k < count; ++k) {
      const auto number = lines_.number<float>(k);
      if (!number)
        return wrong(point() + ": '" + std::string(lines_.word(k).substr(0, 40)) +
                     "' is no number");
      if (k == 3 && !is_weight(*number))
        return wrong(point() + ": the weight must be finite and > 0");
      if (!std::isfinite(*number)) return wrong(point() + " is not finite");
      surface_.numbers.push_back(*number);
    }
    lines_.pass();
    return Status::ok();
  }

  static bool is_weight(float number) { return number > 0 && std::isfinite(number); }

  bool is_one_place(const PatchForm& form, std::size_t first) const {
    const std::size_t stride = form.is_rational != 0 ? 4 : 3;
    for (std::size_t i = first; i < surface_.numbers.size(); ++i) {
      const std::size_t axis = (i - first) % stride;
      if (axis < 3 && surface_.numbers[i] != surface_.numbers[first + axis]) return false;
    }
    return true;
  }

  Status read_trim(const std::string& patch) {
    const auto count = lines_.number<std::uint32_t>(1);
    const std::string_view side = lines_.word(2);
    if (!count || *count == 0 || lines_.count() != 3 || (side != "in" && side != "out"))
      return wrong(patch + ": trim needs a number of loops above 0, and 'in' or 'out'");
    surface_.patches.back().keeps_outside = side == "out" ? 1 : 0;
    lines_.pass();
    surface_.loop_counts.resize(surface_.patches.size(), 0);
    for (std::uint32_t i = 0; i < *count; ++i) {
      if (!lines_.peek() || lines_.word(0) != "loop") {
        return wrong(patch + " announces " + text_of(*count) + " loops, but only " + text_of(i) +
                     " follow");
      }
      TESSERA_RETURN_IF_ERROR(read_loop("loop " + text_of(i) + " of " + patch));
      ++surface_.loop_counts.back();
    }
    return Status::ok();
  }

  Status read_loop(const std::string& loop) {
    const auto segments = lines_.number<std::uint32_t>(1);
    const auto degree = degree_of(lines_.count() > 2 ? lines_.number<int>(2) : kLoopDegree);
    if (!segments || lines_.count() > 3) return wrong(loop + " needs a number of segments");
    if (*segments == 0) return wrong(loop + " has no segment");
    if (!degree) return wrong(loop + ": the degree must lie in 1 to 15");
    if (*segments > kTrimSegmentsMax - surface_.degrees.size())
      return Status::resource_exhausted(path_ + ": more than 2^26 segments of loops");
    lines_.pass();
    const std::size_t first = surface_.trim_points.size();
    const std::uint64_t count = std::uint64_t{*segments} * *degree;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (!lines_.peek() || lines_.word(0) == "loop" || lines_.word(0) == "trim") {
        return wrong(loop + " is open: it has " + text_of(i) + " of " + text_of(count) + " points");
      }
      TESSERA_RETURN_IF_ERROR(read_trim_point(loop, i));
      if ((i + 1) % *degree == 0) surface_.degrees.push_back(*degree);
    }
    bool is_one_place = true;
    for (std::size_t i = first; i < surface_.trim_points.size(); ++i) {
      const TrimPoint &p = surface_.trim_points[i], &q = surface_.trim_points[first];
      is_one_place = is_one_place && p.u == q.u && p.v == q.v;
    }
    if (is_one_place) return wrong(loop + ": all its points are in one place");
    surface_.segment_counts.push_back(*segments);
    return Status::ok();
  }

  Status read_trim_point(const std::string& loop, std::uint64_t index) {
    const auto point = [&] { return "point " + text_of(index) + " of " + loop; };
    const auto u = lines_.number<float>(0), v = lines_.number<float>(1);
    const auto weight = lines_.count() == 3 ? lines_.number<float>(2) : 1.0f;
    if (!u || !v || !weight || lines_.count() > 3)
      return wrong(point() + " needs two numbers, or three with a weight");
    if (!(*u >= 0 && *u <= 1 && *v >= 0 && *v <= 1))  // NaN is outside
      return wrong(point() + " lies outside [0, 1]^2");
    if (!is_weight(*weight)) return wrong(point() + ": the weight must be finite and > 0");
    surface_.trim_points.push_back({*u, *v, *weight});
    lines_.pass();
    return Status::ok();
  }

  const std::string path_;
  WordLines lines_;
  PatchSurface surface_;
};

}  // namespace

Result<ReadScene> read_bpt(const std::string& path) {
  auto text = read_whole_file(path, kFileBytesMax);
  if (!text.is_ok()) return text.status();
  return BptReader(path, *text).read();
}

}  // namespace tessera
