// SPDX-License-Identifier: Apache-2.0
#include "master/import/cad/cell_trims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tessera::import::cad {
namespace {

constexpr double kSnap = 1e-8;          // of the extent: what lies nearer to a border lies on it
constexpr double kFitTolerance = 1e-8;  // of a patch's square: less than a float's last bit at 1
constexpr int kInsideDepthMax = 10;     // of halvings until control points lie in the square
constexpr int kOverrunSteps = 16;       // of a piece beyond the grid, where it is looked at
constexpr int kProbes = 13;             // places of a patch where it is asked what is inside

double Control2::*member(bool is_v) { return is_v ? &Control2::v : &Control2::u; }

// Puts coordinates near a border on it, and those beyond the grid on the grid's end.
void snap(std::vector<Curve2>& loop, const Axis& axis, bool is_v) {
  const double near = kSnap * axis.width();
  for (Curve2& curve : loop) {
    for (Control2& p : curve.points) {
      double& x = p.*member(is_v);
      const auto above = std::ranges::lower_bound(axis.borders, x - near);
      if (above != axis.borders.end() && std::fabs(*above - x) <= near) x = *above;
    }
    // Ends alone: the curve between them is split where it passes the grid's end.
    for (Control2* p : {&curve.points.front(), &curve.points.back()})
      p->*member(is_v) = std::clamp(p->*member(is_v), axis.borders.front(), axis.borders.back());
  }
}

std::vector<Curve2> split_at_borders(const std::vector<Curve2>& loop, const Axis& axis, bool is_v) {
  std::vector<Curve2> pieces;
  for (const Curve2& curve : loop) {
    std::vector<std::pair<double, double>> cuts;  // parameter, border
    for (const double border : axis.borders)
      for (const double t : crossings(curve, is_v, border)) cuts.emplace_back(t, border);
    std::ranges::sort(cuts);
    Curve2 rest = curve;
    double from = 0;
    for (const auto& [t, border] : cuts) {
      if (t - from < 1e-11) continue;
      auto [left, right] = split(rest, (t - from) / (1 - from));
      left.points.back().*member(is_v) = right.points.front().*member(is_v) = border;
      pieces.push_back(std::move(left));
      rest = std::move(right);
      from = t;
    }
    pieces.push_back(std::move(rest));
  }
  return pieces;
}

// The cell that a coordinate lies in; of two, the lower one.
std::size_t cell_of(const Axis& axis, double x) {
  const auto above = std::ranges::lower_bound(axis.borders, x);
  const auto index = std::max<std::ptrdiff_t>(above - axis.borders.begin() - 1, 0);
  return std::min(static_cast<std::size_t>(index), axis.cell_count() - 1);
}

bool is_on_border(const Curve2& curve, const Axis& axis, bool is_v) {
  const double x = curve.points.front().*member(is_v);
  if (!std::ranges::binary_search(axis.borders, x)) return false;
  return std::ranges::all_of(curve.points, [&](const Control2& p) { return p.*member(is_v) == x; });
}

double clamped(double x, const Axis& axis) {
  return std::clamp(x, axis.borders.front(), axis.borders.back());
}

// The place of a piece that is farthest beyond the end of the grid; none where the piece, which is
// split at the borders, lies within.
std::optional<Point2> farthest_beyond(const Curve2& piece, const Axis& u, const Axis& v) {
  const auto excess = [&](Point2 p) {
    return std::max(std::fabs(p.u - clamped(p.u, u)) / u.width(),
                    std::fabs(p.v - clamped(p.v, v)) / v.width());
  };
  if (!(excess(piece.at(0.5)) > 0)) return std::nullopt;
  Point2 worst = piece.at(0.5);
  for (int i = 1; i < kOverrunSteps; ++i) {
    const Point2 p = piece.at(static_cast<double>(i) / kOverrunSteps);
    if (excess(p) > excess(worst)) worst = p;
  }
  return worst;
}

// What is left of a piece beyond the grid: a line along the grid's end.
Curve2 along_end(const Curve2& piece, const Axis& u, const Axis& v) {
  const Point2 middle = piece.at(0.5);
  const Point2 end{clamped(middle.u, u), clamped(middle.v, v)};
  const auto place = [&](Point2 p) {
    return Control2{end.u != middle.u ? end.u : clamped(p.u, u),
                    end.v != middle.v ? end.v : clamped(p.v, v), 1};
  };
  return {{place(piece.first()), place(piece.last())}, piece.edge};
}

using CellPlace = std::pair<std::size_t, std::size_t>;

// The cells beside a curve on a border, of which (i, j) is the lower one.
std::vector<CellPlace> cells_beside(const Curve2& curve, const Axis& u, const Axis& v,
                                    std::size_t i, std::size_t j) {
  std::vector<CellPlace> cells{{i, j}};
  if (is_on_border(curve, u, false) && i + 1 < u.cell_count() &&
      curve.points.front().u == u.borders[i + 1])
    cells.emplace_back(i + 1, j);
  if (is_on_border(curve, v, true) && j + 1 < v.cell_count() &&
      curve.points.front().v == v.borders[j + 1])
    cells.emplace_back(i, j + 1);
  return cells;
}

void add_inside(Curve2 curve, int depth, std::vector<Curve2>& curves) {
  const auto excess = [](double x) { return std::max({-x, x - 1, 0.0}); };
  double worst = 0;
  for (const Control2& p : curve.points) worst = std::max({worst, excess(p.u), excess(p.v)});
  if (worst > kFitTolerance && depth < kInsideDepthMax) {
    auto [left, right] = split(curve, 0.5);
    add_inside(std::move(left), depth + 1, curves);
    add_inside(std::move(right), depth + 1, curves);
    return;
  }
  for (Control2& p : curve.points)
    p = {std::clamp(p.u, 0.0, 1.0), std::clamp(p.v, 0.0, 1.0), p.weight};
  curves.push_back(std::move(curve));
}

// A piece in the square of its patch.
std::vector<Curve2> local_curves(const Curve2& piece, const Axis& u, const Axis& v, std::size_t i,
                                 std::size_t j) {
  const auto place = [&](Point2 p) { return Point2{u.local(i, p.u), v.local(j, p.v)}; };
  const auto is_straight = [&](bool is_v) {
    return piece.points.front().*member(is_v) == piece.points.back().*member(is_v);
  };
  const bool is_line = piece.degree() == 1 && (is_straight(false) || is_straight(true));
  std::vector<Curve2> mapped, inside;
  if (is_line || !(u.is_angle || v.is_angle)) {
    mapped.push_back(piece);
    for (Control2& p : mapped[0].points) {
      const Point2 q = place({p.u, p.v});
      p = {q.u, q.v, p.weight};
    }
  } else {
    mapped = fit([&](double t) { return place(piece.at(t)); }, kFitTolerance);
  }
  for (Curve2& curve : mapped) {
    curve.edge = piece.edge;
    add_inside(std::move(curve), 0, inside);
  }
  return inside;
}

// The way around the square from (0, 0) by (1, 0) to a place of the border; none inside.
std::optional<double> way_around(Point2 p) {
  if (p.v == 0) return p.u;
  if (p.u == 1) return 1 + p.v;
  if (p.v == 1) return 3 - p.u;
  if (p.u == 0) return 4 - p.v;
  return std::nullopt;
}

Point2 on_border(double way) {
  if (way <= 1) return {way, 0};
  if (way <= 2) return {1, way - 1};
  if (way <= 3) return {3 - way, 1};
  return {0, 4 - way};
}

using Chain = std::vector<Curve2>;

// The curves in one patch, and what becomes of them.
class Cell {
 public:
  // Adds what follows `before` in a loop of the face, or begins a chain with it.
  void add(std::vector<Curve2> curves, bool goes_on) {
    for (Curve2& curve : curves) {
      if (!goes_on || way_around(curve.first())) chains_.emplace_back();
      chains_.back().push_back(std::move(curve));
      goes_on = true;
    }
  }

  // `is_inside`: whether a place of the square lies in the face.
  template <class IsInside>
  CellTrims finish(const IsInside& is_inside, int& open_count) {
    CellTrims trims;
    join_ends();
    std::vector<Chain> open;
    for (Chain& chain : chains_) {
      const Point2 first = chain.front().first(), last = chain.back().last();
      const auto a = way_around(first), b = way_around(last);
      if (a && b) {
        // A chain from a place of the border back to it is a loop already.
        if (first == last) {
          trims.loops.push_back(std::move(chain));
        } else {
          open.push_back(std::move(chain));
        }
        continue;
      }
      if (first != last) {
        ++open_count;
        chain.push_back({{{last.u, last.v, 1}, {first.u, first.v, 1}}, -1});
      }
      trims.loops.push_back(std::move(chain));
    }
    if (open.empty()) {
      trims.keeps_outside = !agrees(trims.loops, is_inside);
      trims.is_kept = trims.keeps_outside || !trims.loops.empty();
    } else {
      // One of the two ways to go on along the border makes the face, the other one what is not.
      trims.is_kept = true;
      std::vector<Chain> loops = trims.loops;
      close(open, true, loops);
      if (!agrees(loops, is_inside)) {
        loops = std::move(trims.loops);
        close(open, false, loops);
      }
      trims.loops = std::move(loops);
    }
    return trims;
  }

 private:
  // A place of the border where a chain begins or ends.
  struct Event {
    double way;
    Point2 place;
    std::size_t chain;
    bool is_end;
  };

  // Whether most of some places lie within the loops where they lie in the face. Most: a place may
  // be where curves that nearly touch are told apart by rounding.
  template <class IsInside>
  static bool agrees(const std::vector<Chain>& loops, const IsInside& is_inside) {
    std::vector<Curve2> all;
    for (const Chain& loop : loops) all.insert(all.end(), loop.begin(), loop.end());
    int agreeing = 0;
    for (int i = 0; i < kProbes; ++i) {
      // Places of a golden spiral's kind, of which no two share a coordinate.
      const Point2 p{(i + 0.4721359549) / kProbes, std::fmod((i + 0.3819660112) * 0.6180339887, 1)};
      agreeing += is_enclosed(all, p) == is_inside(p) ? 1 : 0;
    }
    return 2 * agreeing > kProbes;
  }

  // A loop of the face may begin in the middle of a chain.
  void join_ends() {
    for (std::size_t i = 0; i < chains_.size(); ++i) {
      const Point2 first = chains_[i].front().first();
      if (way_around(first) || chains_[i].back().last() == first) continue;
      for (std::size_t j = 0; j < chains_.size(); ++j) {
        if (j == i || chains_[j].back().last() != first) continue;
        chains_[j].insert(chains_[j].end(), chains_[i].begin(), chains_[i].end());
        chains_.erase(chains_.begin() + static_cast<std::ptrdiff_t>(i));
        --i;
        break;
      }
    }
  }

  // Follows chains and what lies inside of the border between them: every other part of it.
  static void close(const std::vector<Chain>& open, bool is_even_inside,
                    std::vector<Chain>& loops) {
    std::vector<Event> events;
    for (std::size_t i = 0; i < open.size(); ++i) {
      const Point2 first = open[i].front().first(), last = open[i].back().last();
      events.push_back({*way_around(first), first, i, false});
      events.push_back({*way_around(last), last, i, true});
    }
    std::ranges::stable_sort(events, {}, &Event::way);
    const std::size_t count = events.size();                        // even
    std::vector<std::array<std::size_t, 2>> of_chain(open.size());  // its first event and its end
    for (std::size_t i = 0; i < count; ++i) of_chain[events[i].chain][events[i].is_end ? 1 : 0] = i;
    std::vector<bool> is_used(open.size(), false);
    for (std::size_t start = 0; start < count; ++start) {
      if (is_used[events[start].chain]) continue;
      Chain loop;
      std::size_t at = start;
      do {
        const Event& event = events[at];
        is_used[event.chain] = true;
        const Chain& chain = open[event.chain];
        if (event.is_end) {
          for (std::size_t i = chain.size(); i-- > 0;) loop.push_back(reversed(chain[i]));
        } else {
          loop.insert(loop.end(), chain.begin(), chain.end());
        }
        const std::size_t other = of_chain[event.chain][event.is_end ? 0 : 1];
        const bool goes_up = is_even_inside == (other % 2 == 0);
        at = (goes_up ? other + 1 : other + count - 1) % count;
        add_border(events[other].way, events[at].way, events[at].place, goes_up, loop);
      } while (!is_used[events[at].chain]);
      loops.push_back(std::move(loop));
    }
  }

  // Adds lines along the border, by the corners between. `goes_up`: the way rises, or passes 4.
  static void add_border(double from, double to, Point2 end, bool goes_up, Chain& loop) {
    Point2 at = loop.back().last();
    const auto go = [&](Point2 p) {
      if (!(p == at)) loop.push_back({{{at.u, at.v, 1}, {p.u, p.v, 1}}, -1});
      at = p;
    };
    if (goes_up && to < from) to += 4;
    if (!goes_up && to > from) to -= 4;
    for (int k = 0; k < 4; ++k) {
      const double corner = goes_up ? std::floor(from) + 1 + k : std::ceil(from) - 1 - k;
      if (goes_up ? corner >= to : corner <= to) break;
      go(on_border(std::fmod(corner + 4, 4.0)));
    }
    go(end);
  }

  std::vector<Chain> chains_;
};

double parameter(const Axis& axis, std::size_t cell, double local) {
  const double a = axis.borders[cell], b = axis.borders[cell + 1];
  if (!axis.is_angle) return a + local * (b - a);
  return (a + b) / 2 + 2 * std::atan((2 * local - 1) * std::tan((b - a) / 4));
}

}  // namespace

Result<FaceTrims> share_out(std::vector<std::vector<Curve2>> loops, const Axis& u, const Axis& v) {
  FaceTrims made;
  std::size_t piece_count = 0;
  std::vector<Cell> cells(u.cell_count() * v.cell_count());
  std::vector<Curve2> all;
  for (auto& loop : loops) {
    snap(loop, u, false);
    snap(loop, v, true);
    all.insert(all.end(), loop.begin(), loop.end());
    const std::vector<Curve2> pieces = split_at_borders(split_at_borders(loop, u, false), v, true);
    std::size_t last_cell = cells.size();
    piece_count += pieces.size();
    if (piece_count > kFacePiecesMax)
      return Status::invalid_argument("its loops cross the borders of patches too often");
    for (const Curve2& given : pieces) {
      const auto beyond = farthest_beyond(given, u, v);
      const Curve2 piece = beyond ? along_end(given, u, v) : given;
      const Point2 middle = piece.at(0.5);
      const std::size_t i = cell_of(u, middle.u), j = cell_of(v, middle.v);
      const std::size_t cell = v.cell_count() * i + j;
      if (beyond) {
        const auto place = [&](Point2 p) { return Point2{u.local(i, p.u), v.local(j, p.v)}; };
        const Point2 border{clamped(beyond->u, u), clamped(beyond->v, v)};
        made.overruns.push_back({piece.edge, cell, place(*beyond), place(border)});
      }
      if (piece.degree() == 1 && piece.first() == piece.last()) continue;
      if (is_on_border(piece, u, false) || is_on_border(piece, v, true)) {
        last_cell = cells.size();
        if (piece.edge < 0) continue;
        // The patches on both sides have it, of which only one may be kept.
        for (const auto& [k, l] : cells_beside(piece, u, v, i, j)) {
          for (Curve2& curve : local_curves(piece, u, v, k, l))
            made.borders.push_back({v.cell_count() * k + l, std::move(curve)});
        }
        continue;
      }
      cells[cell].add(local_curves(piece, u, v, i, j), cell == last_cell);
      last_cell = cell;
    }
  }
  for (std::size_t i = 0; i < u.cell_count(); ++i) {
    for (std::size_t j = 0; j < v.cell_count(); ++j) {
      const auto is_inside = [&](Point2 p) {
        return all.empty() || is_enclosed(all, {parameter(u, i, p.u), parameter(v, j, p.v)});
      };
      made.cells.push_back(cells[v.cell_count() * i + j].finish(is_inside, made.open_count));
    }
  }
  return made;
}

}  // namespace tessera::import::cad
