#include "sgraph_slam/core/places/find_places.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "doors.hpp"
#include "sgraph_slam/core/places/islands.hpp"

namespace sgraph {
namespace {

constexpr double square = 0.1745;      // sides off the right angle by up to this make a rectangle [rad]
constexpr double full = 0.85;          // of the rectangle that four walls make is floor; an L is less
constexpr double one_line = 0.12;      // sides no further apart are of one line [m]
constexpr double inside_share = 0.97;  // of a corridor piece within the outline
constexpr double sample = 0.1;         // [m]
constexpr double wider = 1.25;         // a hall is wider than the corridors that open into it by this factor

Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }
double yaw_of(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }

struct SideLine {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  Eigen::Vector2d direction;  // the place is to its left
  double length = 0;
  PlaceSide side;
};

std::vector<SideLine> sides_of(const Polygon2d& polygon) {
  std::vector<SideLine> sides;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    SideLine side{polygon[i], polygon[(i + 1) % polygon.size()], Eigen::Vector2d::UnitX(), 0, {}};
    side.length = (side.to - side.from).norm();
    if (side.length > 1e-9) side.direction = (side.to - side.from) / side.length;
    sides.push_back(side);
  }
  return sides;
}

// Those of the holes too.
std::vector<SideLine> all_sides(const PlaceOutline& outline) {
  std::vector<SideLine> all;
  const auto add = [&](const PlaceLoop& loop) {
    std::vector<SideLine> sides = sides_of(loop.polygon);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      sides[i].side = loop.sides[i];
      all.push_back(sides[i]);
    }
  };
  add(outline);
  for (const PlaceLoop& hole : outline.holes) add(hole);
  return all;
}

const Wall* find_wall(const std::vector<Wall>& walls, PlaneId id) {
  const auto found = std::find_if(walls.begin(), walls.end(), [&](const Wall& wall) { return wall.id == id; });
  return found == walls.end() ? nullptr : &*found;
}

// Four sides, each on a face, at right angles within the tolerance.
bool is_rectangle(const PlaceOutline& outline) {
  if (outline.polygon.size() != 4 || !outline.holes.empty()) return false;
  const std::vector<SideLine> sides = sides_of(outline.polygon);
  for (std::size_t i = 0; i < 4; ++i) {
    if (!outline.sides[i].plane.valid()) return false;
    if (std::abs(sides[i].direction.dot(sides[(i + 1) % 4].direction)) > std::sin(square)) return false;
  }
  return true;
}

// The four walls of a room, counter-clockwise, and the direction in which the outline runs along each.
struct FourWalls {
  std::array<PlaneId, 4> faces;
  std::array<Eigen::Vector2d, 4> directions;
  std::array<double, 4> lengths{};  // of the outline along each
};

// A room of four walls keeps them where a cabinet or a shaft stands in a corner, a column in its middle, where a corner is cut: each side of the
// rectangle around its outline lies on a face for at least half its length, and next to nothing of the rectangle is missing. What an alcove adds lies
// beyond a wall, which then bounds no more than the alcove.
std::optional<FourWalls> four_walls(const PlaceOutline& outline) {
  const std::vector<SideLine> sides = sides_of(outline.polygon);
  const auto longest = std::max_element(sides.begin(), sides.end(), [](const SideLine& a, const SideLine& b) { return a.length < b.length; });
  FourWalls result;
  double sides_of_box[2] = {0, 0};
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d along = Eigen::Rotation2Dd(static_cast<double>(k) * M_PI / 2) * longest->direction;
    const Eigen::Vector2d outwards = -left_of(along);
    double edge = -std::numeric_limits<double>::infinity();
    Interval extent{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (const Eigen::Vector2d& corner : outline.polygon) {
      edge = std::max(edge, outwards.dot(corner));
      extent = {std::min(extent.low, along.dot(corner)), std::max(extent.high, along.dot(corner))};
    }
    sides_of_box[k % 2] = extent.length();
    double own = 0;  // the longest of the sides on this edge of the rectangle
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const SideLine& side = sides[i];
      const PlaneId face = outline.sides[i].plane;
      if (!face.valid() || side.direction.dot(along) < std::cos(square)) continue;
      // A side may be turned against the rectangle: its far end touches the edge, its middle is as far off as the turn makes it.
      const double turned = 0.5 * side.length * std::abs(side.direction.dot(outwards));
      if (edge - outwards.dot(0.5 * (side.from + side.to)) > turned + one_line) continue;
      result.lengths[k] += side.length;
      if (side.length <= own) continue;
      own = side.length;
      result.faces[k] = face;
      result.directions[k] = side.direction;
    }
    if (result.lengths[k] < 0.5 * extent.length()) return std::nullopt;
  }
  if (!(outline.polygon.size() == 4 && outline.holes.empty()) && area(outline) < full * sides_of_box[0] * sides_of_box[1]) return std::nullopt;
  for (std::size_t k = 0; k < 4; ++k) {
    if (std::abs(result.directions[k].dot(result.directions[(k + 1) % 4])) > std::sin(square)) return std::nullopt;
  }
  return result;
}

// Distance between two facing walls midway, and the position of that middle across.
struct Across {
  double width;
  double middle;  // along `axis`
};

Across between(const Wall& low, const Wall& high, const Eigen::Vector2d& axis, const Eigen::Vector2d& near) {
  const auto crossing = [&](const Wall& wall) { return axis.dot(near) - wall.distance(near) / wall.normal.dot(axis); };
  const double a = crossing(low);
  const double b = crossing(high);
  return {b - a, 0.5 * (a + b)};
}

FoundPlace rectangle_place(const PlaceOutline& outline, const FourWalls& four, const std::vector<Wall>& walls, double reference_yaw,
                           const PlaceParams& params) {
  FoundPlace place;
  place.outline = outline;
  // The heading is that of the longer pair, whose direction is known best. In a frame with its x along the first of them the walls are -y, +x, +y,
  // -x.
  const std::size_t first = four.lengths[0] + four.lengths[2] >= four.lengths[1] + four.lengths[3] ? 0 : 1;
  const Eigen::Vector2d x = (four.directions[first] - four.directions[(first + 2) % 4]).normalized();
  const Eigen::Vector2d y = left_of(x);
  const Eigen::Vector2d middle = centroid(outline.polygon);
  const std::array<PlaneId, 4> faces{four.faces[(first + 3) % 4], four.faces[(first + 1) % 4], four.faces[first], four.faces[(first + 2) % 4]};
  std::array<const Wall*, 4> w{};
  for (std::size_t i = 0; i < 4; ++i) w[i] = find_wall(walls, faces[i]);
  const Across along_x = between(*w[0], *w[1], x, middle);
  const Across along_y = between(*w[2], *w[3], y, middle);
  place.area.center = along_x.middle * x + along_y.middle * y;
  place.area.size = {along_x.width, along_y.width};
  place.area.yaw = yaw_of(x);
  place.walls = faces;
  if (along_y.width <= params.corridor_width && along_x.width >= params.corridor_aspect * along_y.width) {
    place.kind = PlaceKind::corridor;
    place.walls = {faces[2], faces[3], {}, {}};
    const double turned = std::remainder(place.area.yaw - reference_yaw - M_PI / 4, 2 * M_PI);  // in (-90, 90] for headings within (-45, 135]
    if (turned <= -M_PI / 2 || turned > M_PI / 2) {
      std::swap(place.walls[0], place.walls[1]);
      place.area.yaw = std::remainder(place.area.yaw + M_PI, 2 * M_PI);
    }
    return place;
  }
  place.kind = PlaceKind::room;
  const int turns = static_cast<int>(std::lround(std::remainder(reference_yaw - place.area.yaw, 2 * M_PI) / (M_PI / 2)));
  constexpr std::array<Side, 4> around{high_x, high_y, low_x, low_y};
  for (int i = 0; i < 4; ++i) place.walls[around[static_cast<std::size_t>(i)]] = faces[around[static_cast<std::size_t>(((i + turns) % 4 + 4) % 4)]];
  if (turns % 2 != 0) std::swap(place.area.size.x(), place.area.size.y());
  place.area.yaw = std::remainder(place.area.yaw + turns * M_PI / 2, 2 * M_PI);
  return place;
}

OrientedRectangle rectangle_around(const Polygon2d& polygon) {
  const std::vector<SideLine> sides = sides_of(polygon);
  const auto longest = std::max_element(sides.begin(), sides.end(), [](const SideLine& a, const SideLine& b) { return a.length < b.length; });
  const Eigen::Vector2d x = longest->direction;
  const Eigen::Vector2d y = left_of(x);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : polygon) box.extend(Eigen::Vector2d(x.dot(p), y.dot(p)));
  return {box.center().x() * x + box.center().y() * y, box.sizes(), yaw_of(x)};
}

// A straight piece of a corridor in an outline: between two facing sides.
struct Piece {
  Eigen::Vector2d axis;               // along it
  Interval along;                     // with what it reaches into at its ends
  Interval across;                    // to the left of the axis: from the right side to the left one
  std::array<std::size_t, 2> side{};  // of the outline: right and left
  std::array<bool, 2> open{};         // low and high end

  [[nodiscard]] double length() const { return along.length(); }
  [[nodiscard]] double width() const { return across.length(); }
  [[nodiscard]] Eigen::Vector2d at(double s, double t) const { return s * axis + t * left_of(axis); }
};

OrientedRectangle rectangle_of(const Piece& piece) {
  return {piece.at(piece.along.center(), piece.across.center()), {piece.length(), piece.width()}, yaw_of(piece.axis)};
}

// A side that bounds more than it is merely where the seen floor ends.
bool is_wall(const SideLine& side) { return side.side.plane.valid() && side.side.wall + side.side.opening >= 0.6; }

// Where a side and those in line with it run, along an axis.
Intervals run_of(const std::vector<SideLine>& sides, std::size_t index, const Eigen::Vector2d& axis, double max_gap) {
  Intervals parts;
  const Eigen::Vector2d inwards = left_of(sides[index].direction);
  for (std::size_t k = 0; k < sides.size(); ++k) {
    if (sides[k].direction.dot(sides[index].direction) < std::cos(0.1) || !is_wall(sides[k])) continue;
    const Eigen::Vector2d middle = 0.5 * (sides[k].from + sides[k].to);
    if (std::abs(inwards.dot(middle - sides[index].from)) > one_line) continue;
    const double a = axis.dot(sides[k].from);
    const double b = axis.dot(sides[k].to);
    parts.push_back({std::min(a, b), std::max(a, b)});
  }
  return unite(std::move(parts), max_gap);
}

bool section_inside(const PlaceOutline& outline, const Piece& piece, double s) {
  for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    if (!contains(outline, piece.at(s, piece.across.low + share * piece.across.length()))) return false;
  }
  return true;
}

bool runs_inside(const PlaceOutline& outline, const Piece& piece) {
  int all = 0;
  int inside = 0;
  for (double s = piece.along.low + sample; s < piece.along.high - sample; s += sample) {
    ++all;
    inside += section_inside(outline, piece, s) ? 1 : 0;
  }
  return all > 0 && inside >= inside_share * all;
}

// Over a corner or a crossing the piece goes on to the wall ahead; into a hall it does not.
void reach_ends(const PlaceOutline& outline, Piece& piece, double most) {
  for (const bool high : {false, true}) {
    const double end = high ? piece.along.high : piece.along.low;
    double way = 0;
    while (way <= most + sample && section_inside(outline, piece, high ? end + way + 0.5 * sample : end - way - 0.5 * sample)) way += sample;
    double& reached = high ? piece.along.high : piece.along.low;
    if (way > most) {
      piece.open[high] = true;
      continue;
    }
    // To the side of the outline that closes it, exactly.
    const Eigen::Vector2d middle = piece.at(0, piece.across.center());
    double exact = high ? end + way : end - way;
    double least = 2.5 * sample;
    const std::vector<SideLine> sides = all_sides(outline);
    for (const SideLine& side : sides) {
      if (std::abs(side.direction.dot(piece.axis)) > std::sin(square)) continue;
      const Eigen::Vector2d across = left_of(piece.axis);
      const double a = across.dot(side.from);
      const double b = across.dot(side.to);
      if (overlap({std::min(a, b), std::max(a, b)}, piece.across) < 0.5 * piece.width()) continue;
      const Eigen::Vector2d n = left_of(side.direction);
      const double crossing = n.dot(side.from - middle) / n.dot(piece.axis);
      if (std::abs(crossing - (high ? end + way : end - way)) > least) continue;
      least = std::abs(crossing - (high ? end + way : end - way));
      exact = crossing;
    }
    reached = exact;
  }
}

std::vector<Piece> corridor_pieces(const PlaceOutline& outline, const PlaceParams& params) {
  const std::vector<SideLine> sides = all_sides(outline);
  std::vector<Piece> found;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t k = 0; k < sides.size(); ++k) {
      if (i == k || !is_wall(sides[i]) || !is_wall(sides[k])) continue;
      if (sides[i].direction.dot(sides[k].direction) > -std::cos(square)) continue;
      Piece piece;
      piece.axis = (sides[i].direction - sides[k].direction).normalized();
      if (yaw_of(piece.axis) > M_PI / 2 || yaw_of(piece.axis) <= -M_PI / 2) continue;  // the other order gives the other direction
      const Eigen::Vector2d across = left_of(piece.axis);
      piece.side = {i, k};
      const Intervals right = run_of(sides, i, piece.axis, params.max_corridor_gap);
      const Intervals left = run_of(sides, k, piece.axis, params.max_corridor_gap);
      for (const Interval& a : right) {
        for (const Interval& b : left) {
          piece.along = {std::max(a.low, b.low), std::min(a.high, b.high)};
          if (piece.along.length() < params.min_corridor) continue;
          const auto position = [&](const SideLine& side) {
            const double s = piece.along.center();
            const double t = (s - piece.axis.dot(side.from)) / piece.axis.dot(side.direction);
            return across.dot(side.from + t * side.direction);
          };
          piece.across = {position(sides[i]), position(sides[k])};
          if (piece.width() < params.min_corridor_width || piece.width() > params.corridor_width) continue;
          if (piece.length() < 2 * piece.width() || !runs_inside(outline, piece)) continue;
          Piece reached = piece;
          reached.open = {};
          reach_ends(outline, reached, params.corridor_width);
          if (reached.length() >= params.corridor_aspect * reached.width()) found.push_back(reached);
        }
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Piece& a, const Piece& b) { return a.length() > b.length() + 1e-6; });
  // Sides in line give the same piece again.
  std::vector<Piece> distinct;
  for (const Piece& piece : found) {
    const OrientedRectangle own = rectangle_of(piece);
    const bool known =
        std::any_of(distinct.begin(), distinct.end(), [&](const Piece& other) { return shared_area(own, rectangle_of(other)) > 0.5 * own.area(); });
    if (!known) distinct.push_back(piece);
  }
  return distinct;
}

// Of the faces along one side of a piece the one that shows most of it.
const Wall* face_along(const std::vector<Wall>& walls, const Piece& piece, bool left) {
  const Eigen::Vector2d inwards = left ? (-left_of(piece.axis)).eval() : left_of(piece.axis);
  const double at = left ? piece.across.high : piece.across.low;
  const Eigen::Vector2d middle = piece.at(piece.along.center(), at);
  const auto weight = [&](const Wall& wall) {
    const double a = wall.direction().dot(piece.at(piece.along.low, at));
    const double b = wall.direction().dot(piece.at(piece.along.high, at));
    return total_length(clip(wall.support, {std::min(a, b), std::max(a, b)})) * trust(wall);
  };
  const Wall* best = nullptr;
  for (const Wall& wall : walls) {
    if (wall.normal.dot(inwards) < std::cos(0.1) || std::abs(wall.distance(middle)) > one_line) continue;
    if (best == nullptr || weight(wall) > weight(*best)) best = &wall;
  }
  return best != nullptr && weight(*best) > 0 ? best : nullptr;
}

std::optional<FoundPlace> corridor_place(const Piece& piece, const PlaceOutline& outline, const std::vector<Wall>& walls, double reference_yaw) {
  const Wall* right = face_along(walls, piece, false);
  const Wall* left = face_along(walls, piece, true);
  if (right == nullptr || left == nullptr) return std::nullopt;
  FoundPlace place;
  place.kind = PlaceKind::corridor;
  const Eigen::Vector2d axis = piece.axis;
  const Across across = between(*right, *left, left_of(axis), piece.at(piece.along.center(), piece.across.center()));
  place.area.center = piece.along.center() * axis + across.middle * left_of(axis);
  place.area.size = {piece.length(), across.width};
  place.area.yaw = yaw_of(axis);
  place.walls = {right->id, left->id, {}, {}};
  const Interval sides{across.middle - 0.5 * across.width, across.middle + 0.5 * across.width};
  place.outline.polygon = {piece.at(piece.along.low, sides.low), piece.at(piece.along.high, sides.low), piece.at(piece.along.high, sides.high),
                           piece.at(piece.along.low, sides.high)};
  const std::vector<SideLine> side_lines = all_sides(outline);
  place.outline.sides.resize(4);
  place.outline.sides[0] = side_lines[piece.side[0]].side;
  place.outline.sides[0].plane = right->id;
  place.outline.sides[2] = side_lines[piece.side[1]].side;
  place.outline.sides[2].plane = left->id;
  for (const bool high : {false, true}) {
    PlaceSide& end = place.outline.sides[high ? 1 : 3];
    if (piece.open[high]) {
      end.opening = 1;
      continue;
    }
    // The face of the outline that closes it.
    const Eigen::Vector2d p = piece.at(high ? piece.along.high : piece.along.low, sides.center());
    const std::vector<SideLine>& all = side_lines;
    double least = 0.3;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const double distance = std::abs(left_of(all[k].direction).dot(p - all[k].from));
      const double along = all[k].direction.dot(p - all[k].from);
      if (std::abs(all[k].direction.dot(axis)) > std::sin(square) || along < -0.5 || along > all[k].length + 0.5 || distance > least) continue;
      least = distance;
      end = all[k].side;
    }
  }
  const double turned = std::remainder(place.area.yaw - reference_yaw - M_PI / 4, 2 * M_PI);
  if (turned <= -M_PI / 2 || turned > M_PI / 2) {
    std::swap(place.walls[0], place.walls[1]);
    place.area.yaw = std::remainder(place.area.yaw + M_PI, 2 * M_PI);
  }
  return place;
}

// Lines where a piece of a corridor ends in a hall or is open to its side: places are cut there, but not where another piece goes on.
void add_cuts(const Piece& piece, const std::vector<OrientedRectangle>& others, std::vector<WallLine>& lines) {
  const auto cut = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    WallLine line;
    const Eigen::Vector2d u = (to - from).normalized();
    line.normal = left_of(u);
    line.offset = -line.normal.dot(from);
    const double a = line.direction().dot(from);
    const double b = line.direction().dot(to);
    Intervals stretches;
    for (double s = std::min(a, b); s < std::max(a, b); s += 0.5 * sample) {
      const double end = std::min(s + 0.5 * sample, std::max(a, b));
      const Eigen::Vector2d p = line.at(0.5 * (s + end));
      if (std::none_of(others.begin(), others.end(), [&](const OrientedRectangle& other) { return other.contains(p, -0.05); }))
        stretches.push_back({s, end});
    }
    for (const Interval& stretch : unite(std::move(stretches), 1e-6)) {
      Gap gap;
      gap.along = stretch;
      gap.low_jamb = gap.high_jamb = gap.cut = true;
      line.gaps.push_back(gap);
    }
    if (!line.gaps.empty()) lines.push_back(std::move(line));
  };
  cut(piece.at(piece.along.low, piece.across.low), piece.at(piece.along.high, piece.across.low));
  cut(piece.at(piece.along.high, piece.across.high), piece.at(piece.along.low, piece.across.high));
  if (piece.open[1]) cut(piece.at(piece.along.high, piece.across.low), piece.at(piece.along.high, piece.across.high));
  if (piece.open[0]) cut(piece.at(piece.along.low, piece.across.high), piece.at(piece.along.low, piece.across.low));
}

// Share of a region's cells that lie in one of the rectangles.
double share_in(const FreeSpace& space, const Regions& regions, int region, const std::vector<FoundPlace>& places) {
  double all = 0;
  double inside = 0;
  const CellWindow& extent = regions.extent[static_cast<std::size_t>(region)];
  for (int y = extent.y; y < extent.y + extent.height; y += 2) {
    for (int x = extent.x; x < extent.x + extent.width; x += 2) {
      if (regions.at(x, y) != region) continue;
      const Eigen::Vector2d p = space.origin() + space.resolution() * Eigen::Vector2d(x + 0.5, y + 0.5);
      ++all;
      if (std::any_of(places.begin(), places.end(), [&](const FoundPlace& place) { return place.area.contains(p, -0.05); })) ++inside;
    }
  }
  return all > 0 ? inside / all : 1;
}

// The corridors whose middle line runs mostly in a region.
std::vector<std::size_t> corridors_in(const FreeSpace& space, const Regions& regions, int region, const std::vector<FoundPlace>& corridors) {
  std::vector<std::size_t> parts;
  for (std::size_t i = 0; i < corridors.size(); ++i) {
    const OrientedRectangle& area = corridors[i].area;
    const Eigen::Vector2d axis(std::cos(area.yaw), std::sin(area.yaw));
    int known = 0;
    int own = 0;
    for (double s = -0.5 * area.size.x() + sample; s < 0.5 * area.size.x(); s += sample) {
      const Eigen::Vector2d c = ((area.center + s * axis - space.origin()) / space.resolution()).array().floor();
      const int label = regions.at(static_cast<int>(c.x()), static_cast<int>(c.y()));
      known += label >= 0 ? 1 : 0;
      own += label == region ? 1 : 0;
    }
    if (2 * own > known) parts.push_back(i);
  }
  return parts;
}

// What the corridors leave that is large enough to be a hall: wider than a corridor both ways. The rest are corners of their crossings and bends.
std::vector<char> halls_in(const FreeSpace& space, const Regions& regions, const std::vector<FoundPlace>& corridors) {
  double width = 0;
  for (const FoundPlace& corridor : corridors) width += corridor.area.size.y() / static_cast<double>(corridors.size());
  const double cell = space.resolution();
  std::vector<double> size(static_cast<std::size_t>(regions.count), 0);
  for (const std::int32_t label : regions.label) {
    if (label >= 0) size[static_cast<std::size_t>(label)] += cell * cell;
  }
  std::vector<char> halls(size.size(), 0);
  for (std::size_t i = 0; i < halls.size(); ++i) {
    const double least = cell * std::min(regions.extent[i].width, regions.extent[i].height);
    halls[i] = least > wider * width && size[i] > width * width && share_in(space, regions, static_cast<int>(i), corridors) <= 0.5;
  }
  return halls;
}

// Of the cuts behind the first `walls` lines those stretches that have a hall beside them.
void keep_cuts_at_halls(const FreeSpace& space, const Regions& regions, const std::vector<char>& halls, std::size_t walls,
                        std::vector<WallLine>& lines) {
  const auto is_hall = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d c = ((p - space.origin()) / space.resolution()).array().floor();
    const int label = regions.at(static_cast<int>(c.x()), static_cast<int>(c.y()));
    return label >= 0 && halls[static_cast<std::size_t>(label)];
  };
  for (std::size_t k = walls; k < lines.size(); ++k) {
    WallLine& line = lines[k];
    std::vector<Gap> kept;
    for (const Gap& gap : line.gaps) {
      Intervals beside;
      for (double s = gap.along.low; s < gap.along.high; s += 0.5 * sample) {
        const double end = std::min(s + 0.5 * sample, gap.along.high);
        bool hall = false;
        for (const double depth : {-0.2, -0.15, -0.1, 0.1, 0.15, 0.2}) hall = hall || is_hall(line.at(0.5 * (s + end)) + depth * line.normal);
        if (hall) beside.push_back({s, end});
      }
      for (const Interval& stretch : unite(std::move(beside), sample)) {
        kept.push_back(gap);
        kept.back().along = stretch;
      }
    }
    line.gaps = std::move(kept);
  }
  const auto nothing = [](const WallLine& line) { return line.gaps.empty() && line.faces.empty(); };
  lines.erase(std::remove_if(lines.begin() + static_cast<std::ptrdiff_t>(walls), lines.end(), nothing), lines.end());
}

void add_place(const PlaceOutline& outline, const std::vector<Wall>& walls, double reference_yaw, const PlaceParams& params,
               std::vector<FoundPlace>& places) {
  if (area(outline) < params.min_area) return;
  if (const auto four = four_walls(outline)) {
    places.push_back(rectangle_place(outline, *four, walls, reference_yaw, params));
    return;
  }
  FoundPlace place;
  place.outline = outline;
  place.area = rectangle_around(outline.polygon);
  places.push_back(std::move(place));
}

}  // namespace

FoundPlaces find_places(const FreeSpace& space, const std::vector<Wall>& walls, const std::vector<Eigen::Vector2d>& path, double reference_yaw,
                        const PlaceParams& params) {
  FoundPlaces found;
  std::vector<WallLine> lines = find_wall_lines(walls, space, path, params);
  join_over_low_lines(space, params, lines);
  Regions regions = find_regions(space, lines, path, params);
  if (join_recesses(space, regions, lines)) regions = find_regions(space, lines, path, params);
  if (drop_islands(space, regions, lines)) regions = find_regions(space, lines, path, params);
  std::vector<FoundPlace> corridors;
  std::vector<Piece> pieces_of_corridors;
  std::vector<int> composite;
  for (int region = 0; region < regions.count; ++region) {
    if (!regions.entered[static_cast<std::size_t>(region)]) continue;
    const auto outline = find_outline(space, regions, region, lines, walls, params);
    if (!outline) continue;
    std::vector<Piece> pieces;
    if (!is_rectangle(*outline)) pieces = corridor_pieces(*outline, params);
    if (pieces.empty()) {
      add_place(*outline, walls, reference_yaw, params, found.places);
      continue;
    }
    composite.push_back(region);
    for (const Piece& piece : pieces) {
      auto corridor = corridor_place(piece, *outline, walls, reference_yaw);
      if (!corridor) continue;
      corridors.push_back(std::move(*corridor));
      pieces_of_corridors.push_back(piece);
    }
  }
  const std::size_t walls_only = lines.size();
  for (std::size_t i = 0; i < pieces_of_corridors.size(); ++i) {
    std::vector<OrientedRectangle> others;
    for (std::size_t k = 0; k < pieces_of_corridors.size(); ++k) {
      if (k != i) others.push_back(rectangle_of(pieces_of_corridors[k]));
    }
    add_cuts(pieces_of_corridors[i], others, lines);
  }
  if (!composite.empty()) {
    // What the corridors leave of the regions that they are part of.
    Regions rest = find_regions(space, lines, path, params);
    keep_cuts_at_halls(space, rest, halls_in(space, rest, corridors), walls_only, lines);
    rest = find_regions(space, lines, path, params);
    for (int region = 0; region < rest.count; ++region) {
      if (!rest.entered[static_cast<std::size_t>(region)]) continue;
      bool of_composite = false;
      const CellWindow& extent = rest.extent[static_cast<std::size_t>(region)];
      for (int y = extent.y; y < extent.y + extent.height && !of_composite; ++y) {
        for (int x = extent.x; x < extent.x + extent.width && !of_composite; ++x)
          of_composite = rest.at(x, y) == region && std::find(composite.begin(), composite.end(), regions.at(x, y)) != composite.end();
      }
      if (!of_composite) continue;
      const bool corridor = share_in(space, rest, region, corridors) > 0.5;
      const std::vector<std::size_t> parts = corridor ? corridors_in(space, rest, region, corridors) : std::vector<std::size_t>{};
      if (corridor && parts.empty()) continue;
      auto outline = find_outline(space, rest, region, lines, walls, params);
      if (!outline) continue;
      // A corridor alone is its rectangle, unless its floor is more than that: niches, a wider end.
      if (parts.size() == 1 && area(*outline) < wider * corridors[parts[0]].area.area()) continue;
      if (corridor) {
        found.branchings.push_back({std::move(*outline), parts});
      } else {
        add_place(*outline, walls, reference_yaw, params, found.places);
      }
    }
    for (FoundBranching& branching : found.branchings) {
      for (std::size_t& part : branching.parts) part += found.places.size();
    }
    for (FoundPlace& corridor : corridors) found.places.push_back(std::move(corridor));
  }
  found.doors = find_doors(lines, found, params);
  return found;
}

}  // namespace sgraph
