#include "sgraph_slam/core/places/place_outline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "min_cut.hpp"

namespace sgraph {
namespace {

constexpr double margin = 0.6;          // of the cells' frame around the region [m]
constexpr double beside = 0.25;         // a line bounds a region whose cells come this near to its face [m]
constexpr double least_contact = 0.3;   // along this much of it [m]
constexpr double unknown_cost = 0.35;   // of a square metre of unseen floor inside, against one of free floor outside
constexpr double border_cost = 0.5;     // of a metre of border where nothing bounds, in square metres
constexpr double shortest_step = 0.15;  // a shorter side between two parallel ones is no step of the outline [m]

// A piece of floor between lines: side i runs from corner i to the next on lines[side[i]], -1: the frame.
struct Cell {
  Polygon2d corners;
  std::vector<int> side;
  double free = 0;    // of the region [m^2]
  double other = 0;   // of other regions
  double unseen = 0;  // of neither
};

bool has_extent(const Cell& cell) { return cell.corners.size() >= 3 && signed_area(cell.corners) > 1e-6; }

// The part of a cell before a line (sign 1) or behind it (-1). `distances`: of its corners from the line.
Cell part_of(const Cell& cell, const std::vector<double>& distances, int line, double sign) {
  Cell kept;
  const std::size_t n = cell.corners.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d& a = cell.corners[i];
    const Eigen::Vector2d& b = cell.corners[(i + 1) % n];
    const double da = sign * distances[i];
    const double db = sign * distances[(i + 1) % n];
    if (da >= 0) {
      kept.corners.push_back(a);
      kept.side.push_back(cell.side[i]);
      if (db < 0) {
        kept.corners.emplace_back(a + (b - a) * (da / (da - db)));
        kept.side.push_back(line);
      }
    } else if (db > 0) {
      kept.corners.emplace_back(a + (b - a) * (da / (da - db)));
      kept.side.push_back(cell.side[i]);
    }
  }
  return kept;
}

// The arrangement of the lines within a frame. A line crosses few of the cells; the others go on as they are.
std::vector<Cell> cells_between(const std::vector<const WallLine*>& lines, const Eigen::AlignedBox2d& frame) {
  std::vector<Cell> cells{{{frame.min(), {frame.max().x(), frame.min().y()}, frame.max(), {frame.min().x(), frame.max().y()}}, {-1, -1, -1, -1}}};
  std::vector<Cell> next;
  std::vector<double> distances;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    next.clear();
    for (Cell& cell : cells) {
      distances.clear();
      for (const Eigen::Vector2d& corner : cell.corners) distances.push_back(lines[k]->distance(corner));
      const auto [nearest, farthest] = std::minmax_element(distances.begin(), distances.end());
      if (*nearest >= 0 || *farthest <= 0) {
        next.push_back(std::move(cell));
        continue;
      }
      for (const double sign : {1.0, -1.0}) {
        Cell part = part_of(cell, distances, static_cast<int>(k), sign);
        if (has_extent(part)) next.push_back(std::move(part));
      }
    }
    cells.swap(next);
  }
  return cells;
}

// How much of a cell is free floor of the region, of other regions, and unseen.
void measure(Cell& cell, const FreeSpace& space, const Regions& regions, int region) {
  const double size = space.resolution();
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : cell.corners) box.extend(p);
  const auto first = ((box.min() - space.origin()) / size).array().floor().cast<int>().eval();
  const auto last = ((box.max() - space.origin()) / size).array().floor().cast<int>().eval();
  double free = 0;
  double other = 0;
  double all = 0;
  const auto count = [&](int x, int y) {
    all += 1;
    const int label = regions.at(x, y);
    if (label == region) free += 1;
    if (label >= 0 && label != region) other += 1;
  };
  for (int y = first.y(); y <= last.y(); ++y) {
    // The stretch of the row inside the convex cell.
    const double row = space.origin().y() + (y + 0.5) * size;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::size_t i = 0; i < cell.corners.size(); ++i) {
      const Eigen::Vector2d& a = cell.corners[i];
      const Eigen::Vector2d& b = cell.corners[(i + 1) % cell.corners.size()];
      if ((a.y() > row) == (b.y() > row)) continue;
      const double x = a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      low = std::min(low, x);
      high = std::max(high, x);
    }
    if (high < low) continue;  // the first row's and the last row's middle may lie outside
    for (int x = std::max(first.x(), static_cast<int>(std::ceil((low - space.origin().x()) / size - 0.5)));
         x <= last.x() && space.origin().x() + (x + 0.5) * size <= high; ++x)
      count(x, y);
  }
  if (all == 0) {
    const Eigen::Vector2d c = ((centroid(cell.corners) - space.origin()) / size).array().floor();
    count(static_cast<int>(c.x()), static_cast<int>(c.y()));
  }
  const double area = signed_area(cell.corners);
  cell.free = area * free / all;
  cell.other = area * other / all;
  cell.unseen = area - cell.free - cell.other;
}

Interval stretch_on(const WallLine& line, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const double s = line.direction().dot(a);
  const double t = line.direction().dot(b);
  return {std::min(s, t), std::max(s, t)};
}

// How much of a stretch of a line bounds places [m].
double bounded_length(const WallLine& line, Interval stretch) {
  Intervals bounding = line.solid;
  for (const Gap& gap : line.gaps) {
    if (gap.cut) bounding.push_back(gap.along);
  }
  return total_length(clip(unite(std::move(bounding)), stretch));
}

struct BorderPiece {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  int line;
};

// The loops around the cells inside: counter-clockwise around them, clockwise around holes.
std::vector<std::vector<BorderPiece>> loops_of(const std::vector<BorderPiece>& pieces) {
  std::vector<std::vector<BorderPiece>> loops;
  std::vector<char> used(pieces.size(), 0);
  for (std::size_t start = 0; start < pieces.size(); ++start) {
    if (used[start]) continue;
    std::vector<BorderPiece>& loop = loops.emplace_back();
    std::size_t at = start;
    for (;;) {
      used[at] = 1;
      loop.push_back(pieces[at]);
      std::size_t next = pieces.size();
      double turn_of_next = -10;
      const Eigen::Vector2d direction = pieces[at].to - pieces[at].from;
      for (std::size_t k = 0; k < pieces.size(); ++k) {
        if (used[k] || (pieces[k].from - pieces[at].to).norm() > 1e-5) continue;
        const Eigen::Vector2d way = pieces[k].to - pieces[k].from;
        // Where two corners touch the loop keeps to its own cell: the sharpest turn to the left.
        const double turn = std::atan2(direction.x() * way.y() - direction.y() * way.x(), direction.dot(way));
        if (turn > turn_of_next) {
          turn_of_next = turn;
          next = k;
        }
      }
      if (next == pieces.size()) break;
      at = next;
    }
  }
  return loops;
}

double area_within(const std::vector<BorderPiece>& loop) {
  Polygon2d polygon;
  for (const BorderPiece& piece : loop) polygon.push_back(piece.from);
  return signed_area(polygon);
}

bool meet(const Eigen::Vector2d& n1, double d1, const Eigen::Vector2d& n2, double d2, Eigen::Vector2d* p) {
  const double det = n1.x() * n2.y() - n1.y() * n2.x();
  if (std::abs(det) < std::sin(0.14)) return false;
  *p = {(-d1 * n2.y() + d2 * n1.y()) / det, (-d2 * n1.x() + d1 * n2.x()) / det};
  return true;
}

void join_pieces_of_a_line(std::vector<BorderPiece>& loop) {
  for (std::size_t i = 0; i < loop.size() && loop.size() > 3;) {
    const std::size_t k = (i + 1) % loop.size();
    if (loop[i].line == loop[k].line && loop[i].line >= 0) {
      loop[i].to = loop[k].to;
      loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(k));
      if (k < i) --i;
      continue;
    }
    ++i;
  }
}

// Removes short sides between two nearly parallel ones: the shorter of these goes onto the line of the longer.
void drop_steps(std::vector<BorderPiece>& loop) {
  for (bool changed = true; changed && loop.size() > 4;) {
    changed = false;
    for (std::size_t i = 0; i < loop.size() && !changed; ++i) {
      const std::size_t n = loop.size();
      BorderPiece& before = loop[(i + n - 1) % n];
      BorderPiece& after = loop[(i + 1) % n];
      if ((loop[i].to - loop[i].from).norm() > shortest_step) continue;
      const Eigen::Vector2d u = (before.to - before.from).normalized();
      const Eigen::Vector2d v = (after.to - after.from).normalized();
      if (u.dot(v) < 0.98) continue;
      const bool keep_before = (before.to - before.from).norm() >= (after.to - after.from).norm();
      before.to = after.to;
      if (!keep_before) before.line = after.line;
      const std::size_t second = (i + 1) % n;
      std::vector<BorderPiece> kept;
      for (std::size_t k = 0; k < n; ++k) {
        if (k != i && k != second) kept.push_back(loop[k]);
      }
      loop = std::move(kept);
      changed = true;
    }
    if (changed) join_pieces_of_a_line(loop);
  }
}

// The face that shows most of a stretch, of those that show about as much the furthest out.
PlaneId face_of(const WallLine& line, Interval stretch, const std::vector<Wall>& walls, const Wall** chosen) {
  const auto weight = [&](const Wall& wall) {
    const Eigen::Vector2d low = line.at(stretch.low);
    const Eigen::Vector2d high = line.at(stretch.high);
    const double a = wall.direction().dot(low);
    const double b = wall.direction().dot(high);
    return total_length(clip(wall.support, {std::min(a, b), std::max(a, b)})) * trust(wall);
  };
  double most = 0;
  for (const std::size_t i : line.faces) most = std::max(most, weight(walls[i]));
  double furthest = 0;
  *chosen = nullptr;
  for (const std::size_t i : line.faces) {
    if (most <= 0 || weight(walls[i]) < 0.8 * most) continue;
    const double depth = walls[i].distance(line.at(stretch.center()));
    if (*chosen != nullptr && depth <= furthest) continue;
    furthest = depth;
    *chosen = &walls[i];
  }
  return *chosen != nullptr ? (*chosen)->id : PlaneId{};
}

PlaceLoop finished(const std::vector<BorderPiece>& loop, const std::vector<const WallLine*>& lines, const std::vector<int>& index_of,
                   const std::vector<Wall>& walls) {
  PlaceLoop outline;
  const std::size_t n = loop.size();
  std::vector<const Wall*> faces(n, nullptr);
  for (std::size_t i = 0; i < n; ++i) {
    PlaceSide side;
    const int k = loop[i].line;
    if (k >= 0) {
      const WallLine& line = *lines[static_cast<std::size_t>(k)];
      const Interval stretch = stretch_on(line, loop[i].from, loop[i].to);
      side.line = index_of[static_cast<std::size_t>(k)];
      side.plane = face_of(line, stretch, walls, &faces[i]);
      const double length = std::max(1e-6, stretch.length());
      Intervals holes;
      for (const Gap& gap : line.gaps) holes.push_back(gap.along);
      side.opening = total_length(clip(unite(holes), stretch)) / length;
      Intervals seen;
      for (const Interval& part : clip(line.support, stretch)) {
        for (const Interval& rest : gaps(unite(holes), part)) seen.push_back(rest);
      }
      side.wall = total_length(seen) / length;
    }
    outline.sides.push_back(side);
  }
  // Corners where the faces of the two sides meet.
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = (i + n - 1) % n;
    const auto line_of = [&](std::size_t k, Eigen::Vector2d* normal, double* offset) {
      if (faces[k] != nullptr) {
        *normal = faces[k]->normal;
        *offset = faces[k]->offset;
      } else if (loop[k].line >= 0) {
        *normal = lines[static_cast<std::size_t>(loop[k].line)]->normal;
        *offset = lines[static_cast<std::size_t>(loop[k].line)]->offset;
      } else {
        const Eigen::Vector2d u = (loop[k].to - loop[k].from).normalized();
        *normal = {-u.y(), u.x()};
        *offset = -normal->dot(loop[k].from);
      }
    };
    Eigen::Vector2d n1;
    Eigen::Vector2d n2;
    double d1 = 0;
    double d2 = 0;
    line_of(before, &n1, &d1);
    line_of(i, &n2, &d2);
    Eigen::Vector2d corner = loop[i].from;
    Eigen::Vector2d crossing;
    if (meet(n1, d1, n2, d2, &crossing) && (crossing - corner).norm() < 0.25) corner = crossing;
    outline.polygon.push_back(corner);
  }
  return outline;
}

}  // namespace

std::optional<PlaceOutline> find_outline(const FreeSpace& space, const Regions& regions, int region, const std::vector<WallLine>& lines,
                                         const std::vector<Wall>& walls, const PlaceParams& params) {
  const CellWindow& extent = regions.extent[static_cast<std::size_t>(region)];
  const Eigen::Vector2d low = space.origin() + space.resolution() * Eigen::Vector2d(extent.x, extent.y);
  const Eigen::Vector2d high = low + space.resolution() * Eigen::Vector2d(extent.width, extent.height);
  const Eigen::AlignedBox2d frame(Eigen::Vector2d(low.array() - margin), Eigen::Vector2d(high.array() + margin));
  const auto label_at = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d c = ((p - space.origin()) / space.resolution()).array().floor();
    return regions.at(static_cast<int>(c.x()), static_cast<int>(c.y()));
  };
  std::vector<const WallLine*> near;
  std::vector<int> index_of;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const WallLine& line = lines[k];
    double contact = 0;
    constexpr double step = 0.1;
    Intervals parts = line.solid;
    for (const Gap& gap : line.gaps) {
      if (gap.cut) parts.push_back(gap.along);
    }
    for (const Interval& part : parts) {
      for (double s = part.low + 0.5 * step; s < part.high; s += step) {
        bool touches = false;
        for (double d = 0.05; d <= beside && !touches; d += 0.05) touches = label_at(line.at(s) + d * line.normal) == region;
        if (touches) contact += step;
      }
    }
    if (contact < least_contact) continue;
    near.push_back(&line);
    index_of.push_back(static_cast<int>(k));
  }
  std::vector<Cell> cells = cells_between(near, frame);
  MinCut cut(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    measure(cells[i], space, regions, region);
    cut.add_node(i, cells[i].free, cells[i].other + unknown_cost * cells[i].unseen);
  }
  // Cells and their sides, by the line that the side lies on.
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> on_line(near.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (std::size_t s = 0; s < cells[i].corners.size(); ++s) {
      if (cells[i].side[s] >= 0) on_line[static_cast<std::size_t>(cells[i].side[s])].emplace_back(i, s);
    }
  }
  const auto neighbour = [&](std::size_t i, std::size_t s) {
    const Eigen::Vector2d from = cells[i].corners[s];
    const Eigen::Vector2d to = cells[i].corners[(s + 1) % cells[i].corners.size()];
    for (const auto& [k, t] : on_line[static_cast<std::size_t>(cells[i].side[s])]) {
      const Polygon2d& corners = cells[k].corners;
      if (k != i && (corners[t] - to).norm() < 1e-5 && (corners[(t + 1) % corners.size()] - from).norm() < 1e-5) return k;
    }
    return cells.size();
  };
  std::vector<std::vector<std::size_t>> neighbours(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (std::size_t s = 0; s < cells[i].corners.size(); ++s) {
      const std::size_t k = cells[i].side[s] < 0 ? cells.size() : neighbour(i, s);
      neighbours[i].push_back(k);
      if (k <= i || k == cells.size()) continue;
      const WallLine& line = *near[static_cast<std::size_t>(cells[i].side[s])];
      const Interval stretch = stretch_on(line, cells[i].corners[s], cells[i].corners[(s + 1) % cells[i].corners.size()]);
      cut.add_pair(i, k, border_cost * std::max(0.0, stretch.length() - bounded_length(line, stretch)));
    }
  }
  const std::vector<char> inside = cut.solve();
  std::vector<BorderPiece> border;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!inside[i]) continue;
    for (std::size_t s = 0; s < cells[i].corners.size(); ++s) {
      const std::size_t k = neighbours[i][s];
      if (k < cells.size() && inside[k]) continue;
      border.push_back({cells[i].corners[s], cells[i].corners[(s + 1) % cells[i].corners.size()], cells[i].side[s]});
    }
  }
  std::vector<std::vector<BorderPiece>> loops = loops_of(border);
  const auto larger = [](const auto& a, const auto& b) { return area_within(a) < area_within(b); };
  const auto outer = std::max_element(loops.begin(), loops.end(), larger);
  if (outer == loops.end()) return std::nullopt;
  const auto simplify = [](std::vector<BorderPiece>& loop) {
    if (loop.size() < 3) return false;
    join_pieces_of_a_line(loop);
    drop_steps(loop);
    return loop.size() >= 3;
  };
  if (!(area_within(*outer) > 0) || !simplify(*outer)) return std::nullopt;
  PlaceOutline outline;
  static_cast<PlaceLoop&>(outline) = finished(*outer, near, index_of, walls);
  for (auto& loop : loops) {
    if (area_within(loop) > -params.min_area || !simplify(loop) || !contains(outline.polygon, loop.front().from)) continue;
    outline.holes.push_back(finished(loop, near, index_of, walls));
  }
  return outline;
}

bool contains(const PlaceOutline& outline, const Eigen::Vector2d& p) {
  return contains(outline.polygon, p) &&
         std::none_of(outline.holes.begin(), outline.holes.end(), [&](const PlaceLoop& hole) { return contains(hole.polygon, p); });
}

double area(const PlaceOutline& outline) {
  double sum = signed_area(outline.polygon);
  for (const PlaceLoop& hole : outline.holes) sum -= std::abs(signed_area(hole.polygon));
  return sum;
}

std::vector<Polygon2d> hole_polygons(const PlaceOutline& outline) {
  std::vector<Polygon2d> polygons;
  for (const PlaceLoop& hole : outline.holes) polygons.push_back(hole.polygon);
  return polygons;
}

}  // namespace sgraph
