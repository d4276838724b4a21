#include "corridor_pieces.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace sgraph {
namespace {

constexpr double inside_share = 0.97;  // of a corridor piece within the outline
constexpr double section = 0.1;        // between sections of a piece [m]

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

bool section_inside(const PlaceOutline& outline, const CorridorPiece& piece, double s) {
  for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    if (!contains(outline, piece.at(s, piece.across.low + share * piece.across.length()))) return false;
  }
  return true;
}

bool runs_inside(const PlaceOutline& outline, const CorridorPiece& piece) {
  int all = 0;
  int inside = 0;
  for (double s = piece.along.low + section; s < piece.along.high - section; s += section) {
    ++all;
    inside += section_inside(outline, piece, s) ? 1 : 0;
  }
  return all > 0 && inside >= inside_share * all;
}

// Over a corner or a crossing the piece goes on to the wall ahead; into a hall it does not.
void reach_ends(const PlaceOutline& outline, CorridorPiece& piece, double most) {
  for (const bool high : {false, true}) {
    const double end = high ? piece.along.high : piece.along.low;
    double way = 0;
    while (way <= most + section && section_inside(outline, piece, high ? end + way + 0.5 * section : end - way - 0.5 * section)) way += section;
    double& reached = high ? piece.along.high : piece.along.low;
    if (way > most) {
      piece.open[high] = true;
      continue;
    }
    // To the side of the outline that closes it, exactly.
    const Eigen::Vector2d middle = piece.at(0, piece.across.center());
    double exact = high ? end + way : end - way;
    double least = 2.5 * section;
    const std::vector<SideLine> sides = all_sides(outline);
    for (const SideLine& side : sides) {
      if (std::abs(side.direction.dot(piece.axis)) > std::sin(right_angle)) continue;
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

// Of the faces along one side of a piece the one that shows most of it.
const Wall* face_along(const std::vector<Wall>& walls, const CorridorPiece& piece, bool left) {
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

}  // namespace

OrientedRectangle rectangle_of(const CorridorPiece& piece) {
  return {piece.at(piece.along.center(), piece.across.center()), {piece.length(), piece.width()}, yaw_of(piece.axis)};
}

std::vector<CorridorPiece> corridor_pieces(const PlaceOutline& outline, const PlaceParams& params) {
  const std::vector<SideLine> sides = all_sides(outline);
  std::vector<CorridorPiece> found;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t k = 0; k < sides.size(); ++k) {
      if (i == k || !is_wall(sides[i]) || !is_wall(sides[k])) continue;
      if (sides[i].direction.dot(sides[k].direction) > -std::cos(right_angle)) continue;
      CorridorPiece piece;
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
          CorridorPiece reached = piece;
          reached.open = {};
          reach_ends(outline, reached, params.corridor_width);
          if (reached.length() >= params.corridor_aspect * reached.width()) found.push_back(reached);
        }
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const CorridorPiece& a, const CorridorPiece& b) { return a.length() > b.length() + 1e-6; });
  // Sides in line give the same piece again.
  std::vector<CorridorPiece> distinct;
  for (const CorridorPiece& piece : found) {
    const OrientedRectangle own = rectangle_of(piece);
    const bool known = std::any_of(distinct.begin(), distinct.end(),
                                   [&](const CorridorPiece& other) { return shared_area(own, rectangle_of(other)) > 0.5 * own.area(); });
    if (!known) distinct.push_back(piece);
  }
  return distinct;
}

std::optional<FoundPlace> corridor_place(const CorridorPiece& piece, const PlaceOutline& outline, const std::vector<Wall>& walls,
                                         double reference_yaw) {
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
      if (std::abs(all[k].direction.dot(axis)) > std::sin(right_angle) || along < -0.5 || along > all[k].length + 0.5 || distance > least) continue;
      least = distance;
      end = all[k].side;
    }
  }
  head_as_reference(place, reference_yaw);
  return place;
}

void add_cuts(const CorridorPiece& piece, const std::vector<OrientedRectangle>& others, std::vector<WallLine>& lines) {
  const auto cut = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    WallLine line;
    const Eigen::Vector2d u = (to - from).normalized();
    line.normal = left_of(u);
    line.offset = -line.normal.dot(from);
    const double a = line.direction().dot(from);
    const double b = line.direction().dot(to);
    Intervals stretches;
    for (double s = std::min(a, b); s < std::max(a, b); s += 0.5 * section) {
      const double end = std::min(s + 0.5 * section, std::max(a, b));
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

}  // namespace sgraph
