// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/cost_map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace tessera::sim {
namespace {

constexpr std::size_t kNumbersMax = 1'000'000;

// Reads numbers between commas; lines that begin with '#' are comments. Returns: an error that
// names what is no number.
Status read_numbers(std::istream& in, std::vector<double>& numbers) {
  std::string line;
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    for (std::string word; std::getline(words, word, ',');) {
      char* end = nullptr;
      const double value = std::strtod(word.c_str(), &end);
      if (end == word.c_str() || *end != '\0' || !(value >= 0) || !std::isfinite(value))
        return Status::invalid_argument("'" + word + "' is no number of microseconds");
      if (numbers.size() >= kNumbersMax) return Status::invalid_argument("too many numbers");
      numbers.push_back(value);
    }
  }
  return Status::ok();
}

bool is_edge(double value) { return value >= 1 && value <= 65536 && value == std::floor(value); }

}  // namespace

Result<CostMap> CostMap::read(const std::string& path) {
  std::ifstream file(path);
  if (!file) return Status::not_found(path + ": cannot be read; give the folder with --costs");
  std::ostringstream text;
  text << file.rdbuf();
  return parse(text.str(), path);
}

Result<CostMap> CostMap::parse(const std::string& text, const std::string& path) {
  std::istringstream in(text);
  std::vector<double> numbers;
  if (const Status status = read_numbers(in, numbers); !status.is_ok())
    return Status::invalid_argument(path + ": " + status.message());
  if (numbers.size() < 4 || !std::all_of(numbers.begin(), numbers.begin() + 4, is_edge))
    return Status::invalid_argument(path + ": it begins with width, height, tile edge, frames");
  CostMap map;
  map.width_px_ = static_cast<int>(numbers[0]);
  map.height_px_ = static_cast<int>(numbers[1]);
  map.edge_px_ = static_cast<int>(numbers[2]);
  map.frame_count_ = static_cast<int>(numbers[3]);
  map.grid_ = TileGrid(map.width_px_, map.height_px_, map.edge_px_);
  const std::size_t tiles = map.grid_.tile_count();
  if (numbers.size() - 4 != tiles * static_cast<std::size_t>(map.frame_count_)) {
    return Status::invalid_argument(path + ": " + std::to_string(numbers.size() - 4) +
                                    " times for " + std::to_string(map.frame_count_) +
                                    " frames of " + std::to_string(tiles) + " tiles");
  }
  for (std::size_t i = 0; i + 4 < numbers.size(); ++i) {
    const int pixels = map.grid_.rect(static_cast<TileIndex>(i % tiles)).pixel_count();
    map.seconds_.push_back(1e-6 * numbers[i + 4] / pixels);
  }
  return map;
}

const double* CostMap::row_of(FrameId frame, int row) const {
  const auto count = static_cast<FrameId>(frame_count_);
  const FrameId turn = count > 1 ? frame % (2 * count - 2) : 0;  // 0 1 2 3 2 1 | 0 1 2 3 2 1
  const FrameId there = turn < count ? turn : 2 * count - 2 - turn;
  const auto line = static_cast<std::size_t>(there) * static_cast<std::size_t>(grid_.rows()) +
                    static_cast<std::size_t>(row);
  return seconds_.data() + line * static_cast<std::size_t>(grid_.columns());
}

double CostMap::tile_seconds(FrameId frame, const TileRect& rect, int width_px,
                             int height_px) const {
  // Pixels of the recorded frame for each pixel of this one.
  const double across = static_cast<double>(width_px_) / width_px;
  const double down = static_cast<double>(height_px_) / height_px;
  const double left = rect.x_px * across, right = (rect.x_px + rect.width_px) * across;
  const double top = rect.y_px * down, bottom = (rect.y_px + rect.height_px) * down;
  double sum = 0;
  const int last_row = std::min(static_cast<int>(bottom / edge_px_), grid_.rows() - 1);
  const int last_column = std::min(static_cast<int>(right / edge_px_), grid_.columns() - 1);
  for (int row = static_cast<int>(top / edge_px_); row <= last_row; ++row) {
    const double height =
        std::min<double>(bottom, (row + 1) * edge_px_) - std::max<double>(top, row * edge_px_);
    const double* const line = row_of(frame, row);
    for (int column = static_cast<int>(left / edge_px_); column <= last_column; ++column) {
      const double width = std::min<double>(right, (column + 1) * edge_px_) -
                           std::max<double>(left, column * edge_px_);
      sum += line[column] * std::max(width, 0.0) * std::max(height, 0.0);
    }
  }
  return sum / (across * down);
}

double CostMap::frame_seconds(FrameId frame) const {
  return tile_seconds(frame, {0, 0, width_px_, height_px_}, width_px_, height_px_);
}

}  // namespace tessera::sim
