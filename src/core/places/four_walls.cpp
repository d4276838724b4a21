#include "four_walls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "outline_sides.hpp"

namespace sgraph {
namespace {

constexpr double full = 0.85;  // of the rectangle that four walls make is floor; an L is less

}  // namespace

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
      if (!face.valid() || side.direction.dot(along) < std::cos(right_angle)) continue;
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
    if (std::abs(result.directions[k].dot(result.directions[(k + 1) % 4])) > std::sin(right_angle)) return std::nullopt;
  }
  return result;
}

FoundPlace room_or_corridor(const PlaceOutline& outline, const FourWalls& four, const std::vector<Wall>& walls, double reference_yaw,
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
    head_as_reference(place, reference_yaw);
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

}  // namespace sgraph
