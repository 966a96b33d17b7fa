// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/grid_sort.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "slave/core/accel/run_tasks.h"

namespace tessera::core {
namespace {

// A cell of a grid whose centroids lie on a surface has about this many; ranges of no more are left
// to the builder.
constexpr float kRefsPerCell = 64;
constexpr double kCellsMax = 1 << 19;
// A task takes at least so many boxes.
constexpr std::size_t kTaskBoxesMin = 16384;
constexpr std::uint32_t kNoCell = 0xffffffffu;

struct Corners {
  Float4 lower, upper;  // the fourth lane is any number of the box

  // Both registers are read from the six floats of the box alone.
  explicit Corners(const Bounds3f& box) {
    const float* const from = &box.lower.x;
    lower.v = _mm_loadu_ps(from);
    const __m128 last = _mm_loadu_ps(from + 2);
    upper.v = _mm_shuffle_ps(last, last, _MM_SHUFFLE(3, 3, 2, 1));
  }
  bool is_empty() const { return (_mm_movemask_ps(_mm_cmpgt_ps(lower.v, upper.v)) & 7) != 0; }
  Float4 centroid() const { return lower + upper; }
};
static_assert(sizeof(Bounds3f) == 6 * sizeof(float));

// Maps doubled centroids to cells.
class Grid {
 public:
  Grid(const Box4& centroids, std::uint32_t count) : origin_(centroids.lower) {
    float extent[3];
    for (int a = 0; a < 3; ++a) extent[a] = centroids.upper[a] - centroids.lower[a];
    const double cells = std::max(1.0f, static_cast<float>(count) / kRefsPerCell);
    const double area = double{extent[0]} * extent[1] + double{extent[1]} * extent[2] +
                        double{extent[2]} * extent[0];
    const double longest = *std::max_element(extent, extent + 3);
    double edge = std::max(std::sqrt(area / cells), longest / cells);
    constexpr double kCubeRootOf2 = 1.26;
    for (; !set_edge(extent, edge); edge *= kCubeRootOf2) {
    }
  }
  std::uint32_t cell_count() const { return size_[0] * size_[1] * size_[2]; }
  std::uint32_t cell_of(Float4 centroid) const {
    const __m128i at = _mm_cvttps_epi32(((centroid - origin_) * scale_).v);
    alignas(16) std::uint32_t lane[4];
    _mm_store_si128(reinterpret_cast<__m128i*>(lane), at);
    return (lane[2] * size_[1] + lane[1]) * size_[0] + lane[0];
  }

 private:
  // Returns: false where there would be too many cells.
  bool set_edge(const float (&extent)[3], double edge) {
    alignas(16) float scale[4] = {};
    double cells = 1;
    for (int a = 0; a < 3; ++a) {
      const double wanted = std::ceil(double{extent[a]} / edge);
      const bool is_cut = extent[a] > 0 && std::isfinite(extent[a]) && wanted > 1;
      const double size = is_cut ? std::min(wanted, kCellsMax) : 1;
      // The scale is just below the size, so that the last centroid falls into the last cell.
      const auto per_unit = is_cut ? static_cast<float>(size * 0.9999 / double{extent[a]}) : 0;
      scale[a] = std::isfinite(per_unit) ? per_unit : 0;
      size_[a] = scale[a] > 0 ? static_cast<std::uint32_t>(size) : 1;
      cells *= size_[a];
    }
    scale_ = load4(scale);
    return cells <= kCellsMax;
  }

  Float4 origin_, scale_{};
  std::uint32_t size_[3] = {1, 1, 1};
};

// What lies in a cell, or in a part of all boxes.
struct Content {
  Box4 bounds, centroids;
  std::uint32_t count = 0;

  void grow(const Corners& corners) {
    bounds.grow(corners.lower, corners.upper);
    const Float4 centroid = corners.centroid();
    centroids.grow(centroid, centroid);
    ++count;
  }
  void grow(const Content& other) {
    bounds.grow(other.bounds);
    centroids.grow(other.centroids);
    count += other.count;
  }
  // The fourfold middle of the centroids.
  Float4 middle() const { return centroids.lower + centroids.upper; }
};

// The top of the hierarchy, over cells.
class CellTree {
 public:
  CellTree(std::span<const Content> cells, std::uint32_t block_size)
      : cells_(cells), block_size_(block_size), order_(cells.size()), first_(cells.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, order_.size(), 0);
  }
  // Where the references of each cell begin. Shape: [cell].
  const std::vector<std::uint32_t>& first() const { return first_; }
  std::vector<GridRange> take() { return std::move(ranges_); }

 private:
  static constexpr int kBins = 16;
  struct Cut {
    int axis = -1;
    int bin = 0;
    float cost = std::numeric_limits<float>::infinity();
  };
  // Maps the middles of cells to bins.
  struct Map {
    Float4 origin, scale;
    explicit Map(const Box4& middles) : origin(middles.lower) {
      alignas(16) float lanes[4] = {};
      for (int a = 0; a < 3; ++a) {
        const float extent = middles.upper[a] - middles.lower[a];
        const float per_unit = kBins * 0.9999f / extent;
        lanes[a] = extent > 0 && std::isfinite(per_unit) ? per_unit : 0;
      }
      scale = load4(lanes);
    }
    void bins_of(const Content& cell, int (&bins)[4]) const {
      const Float4 at = (cell.middle() - origin) * scale;
      _mm_storeu_si128(reinterpret_cast<__m128i*>(bins), _mm_cvttps_epi32(at.v));
    }
  };

  std::uint32_t build(std::size_t begin, std::size_t end, int depth) {
    const auto index = static_cast<std::uint32_t>(ranges_.size());
    Content all;
    Box4 middles;
    for (std::size_t i = begin; i < end; ++i) {
      all.grow(cells_[order_[i]]);
      middles.grow(cells_[order_[i]].middle(), cells_[order_[i]].middle());
    }
    RefRange range{placed_, placed_ + all.count, placed_ + all.count, all.bounds, all.centroids};
    ranges_.push_back({range});
    const bool is_small = static_cast<float>(all.count) <= kRefsPerCell;
    if (end - begin == 1 || is_small || depth == kGridDepthMax) {
      for (std::size_t i = begin; i < end; ++i) {
        first_[order_[i]] = placed_;
        placed_ += cells_[order_[i]].count;
      }
      return index;
    }
    const std::size_t middle = split(begin, end, Map(middles));
    const std::uint32_t left = build(begin, middle, depth + 1);
    const std::uint32_t right = build(middle, end, depth + 1);
    ranges_[index].left = left;
    ranges_[index].right = right;
    return index;
  }

  // Orders the cells by the cheapest cut. Returns: the first one of the right half.
  std::size_t split(std::size_t begin, std::size_t end, const Map& map) {
    const Cut cut = cheapest(begin, end, map);
    if (cut.axis < 0) return begin + (end - begin) / 2;
    const auto first = order_.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = order_.begin() + static_cast<std::ptrdiff_t>(end);
    const auto middle = std::partition(first, last, [&](std::uint32_t cell) {
      int bins[4];
      map.bins_of(cells_[cell], bins);
      return bins[cut.axis] <= cut.bin;
    });
    return static_cast<std::size_t>(middle - order_.begin());
  }

  Cut cheapest(std::size_t begin, std::size_t end, const Map& map) {
    for (auto& axis : bins_) std::fill_n(axis, kBins, Content{});
    for (std::size_t i = begin; i < end; ++i) {
      int bins[4];
      map.bins_of(cells_[order_[i]], bins);
      for (int a = 0; a < 3; ++a) {
        bins_[a][bins[a]].bounds.grow(cells_[order_[i]].bounds);
        bins_[a][bins[a]].count += cells_[order_[i]].count;
      }
    }
    Cut best;
    for (int a = 0; a < 3; ++a) {
      if (map.scale[a] > 0) weigh(a, best);
    }
    return best;
  }

  // Keeps the cheapest cut on the axis if it is the cheapest so far.
  void weigh(int axis, Cut& best) const {
    const Content* const bins = bins_[axis];
    float right_cost[kBins];
    Box4 box;
    std::uint32_t count = 0;
    for (int b = kBins - 1; b > 0; --b) {
      box.grow(bins[b].bounds);
      count += bins[b].count;
      right_cost[b] = count == 0 ? std::numeric_limits<float>::infinity()
                                 : box.half_area() * blocks_of(count, block_size_);
    }
    box = {};
    count = 0;
    for (int b = 0; b + 1 < kBins; ++b) {
      box.grow(bins[b].bounds);
      count += bins[b].count;
      if (count == 0) continue;
      const float cost = box.half_area() * blocks_of(count, block_size_) + right_cost[b + 1];
      if (cost < best.cost) best = {axis, b, cost};
    }
  }

  const std::span<const Content> cells_;
  const std::uint32_t block_size_;
  std::vector<std::uint32_t> order_, first_;
  std::vector<GridRange> ranges_;
  std::uint32_t placed_ = 0;  // references of cells that have their place
  Content bins_[3][kBins];
};

// The boxes of one task, and what it finds in them.
struct Part {
  std::size_t begin = 0, end = 0;
  Content all;
  std::vector<std::uint32_t> counts;  // by cell; then where the next reference goes
  std::vector<Content> cells;         // of those that are not empty
};

class Sorter {
 public:
  Sorter(std::span<const Bounds3f> boxes, int thread_count)
      : boxes_(boxes), thread_count_(thread_count) {
    const std::size_t parts = std::clamp<std::size_t>(boxes.size() / kTaskBoxesMin, 1,
                                                      static_cast<std::size_t>(thread_count));
    parts_.resize(parts);
    for (std::size_t i = 0; i < parts; ++i) {
      parts_[i].begin = boxes.size() * i / parts;
      parts_[i].end = boxes.size() * (i + 1) / parts;
    }
  }

  GridSorted sort(std::uint32_t block_size) {
    measure();
    GridSorted sorted;
    if (all_.count == 0) return sorted;
    count_cells(Grid(all_.centroids, all_.count));
    std::vector<Content> cells = fill_cells();
    CellTree tree(cells, block_size);
    sorted.ranges = tree.take();
    sorted.references.refs.resize(all_.count);
    sorted.references.all = sorted.ranges[0].range;
    place(tree.first(), sorted.references.refs.data());
    return sorted;
  }

 private:
  template <typename Work>
  void for_parts(const Work& work) {
    run_tasks(static_cast<int>(parts_.size()), thread_count_,
              [&](int i) { work(parts_[static_cast<std::size_t>(i)]); });
  }

  void measure() {
    for_parts([&](Part& part) {
      for (std::size_t p = part.begin; p < part.end; ++p) {
        const Corners corners(boxes_[p]);
        if (!corners.is_empty()) part.all.grow(corners);
      }
    });
    for (const Part& part : parts_) all_.grow(part.all);
  }

  // Finds the cell of each box, and gives numbers to the cells that are not empty.
  void count_cells(const Grid& grid) {
    cell_of_.resize(boxes_.size());
    for_parts([&](Part& part) {
      part.counts.assign(grid.cell_count(), 0);
      for (std::size_t p = part.begin; p < part.end; ++p) {
        const Corners corners(boxes_[p]);
        cell_of_[p] = corners.is_empty() ? kNoCell : grid.cell_of(corners.centroid());
        if (cell_of_[p] != kNoCell) ++part.counts[cell_of_[p]];
      }
    });
    number_of_.resize(grid.cell_count());
    for (std::uint32_t cell = 0; cell < grid.cell_count(); ++cell) {
      std::uint32_t count = 0;
      for (const Part& part : parts_) count += part.counts[cell];
      if (count == 0) continue;
      number_of_[cell] = static_cast<std::uint32_t>(cells_used_.size());
      cells_used_.push_back(cell);
    }
  }

  std::vector<Content> fill_cells() {
    for_parts([&](Part& part) {
      part.cells.resize(cells_used_.size());
      for (std::size_t p = part.begin; p < part.end; ++p) {
        if (cell_of_[p] != kNoCell) part.cells[number_of_[cell_of_[p]]].grow(Corners(boxes_[p]));
      }
    });
    std::vector<Content> cells(cells_used_.size());
    for (const Part& part : parts_) {
      for (std::size_t c = 0; c < cells.size(); ++c) cells[c].grow(part.cells[c]);
    }
    return cells;
  }

  // Within a cell references stand in the order of their primitives.
  void place(const std::vector<std::uint32_t>& first, PrimitiveRef* refs) {
    for (std::size_t c = 0; c < first.size(); ++c) {
      std::uint32_t next = first[c];
      for (Part& part : parts_) {
        std::uint32_t& count = part.counts[cells_used_[c]];
        next += std::exchange(count, next);
      }
    }
    for_parts([&](Part& part) {
      for (std::size_t p = part.begin; p < part.end; ++p) {
        if (cell_of_[p] == kNoCell) continue;
        const Corners corners(boxes_[p]);
        PrimitiveRef& ref = refs[part.counts[cell_of_[p]]++];
        _mm_store_ps(ref.lower, corners.lower.v);
        _mm_store_ps(ref.upper, corners.upper.v);
        ref.primitive = static_cast<std::uint32_t>(p);
        ref.one = 1;
      }
    });
  }

  const std::span<const Bounds3f> boxes_;
  const int thread_count_;
  std::vector<Part> parts_;
  Content all_;
  std::vector<std::uint32_t> cell_of_;     // by box
  std::vector<std::uint32_t> number_of_;   // by cell of the grid
  std::vector<std::uint32_t> cells_used_;  // by number
};

}  // namespace

GridSorted grid_sort(std::span<const Bounds3f> boxes, std::uint32_t block_size, int thread_count) {
  return Sorter(boxes, thread_count).sort(block_size);
}

}  // namespace tessera::core
