#include "plan.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace sgraph::sim {

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

// What two walls that meet must go beyond the corner for their outer faces to meet.
double corner_extension(const Eigen::Vector2d& in, const Eigen::Vector2d& out, double thickness) {
  const double turn = std::abs(std::atan2(cross(in, out), in.dot(out)));
  return 0.5 * thickness * std::tan(0.5 * std::min(turn, 2.2));
}

}  // namespace

std::vector<Wall> walls_along(const std::vector<Eigen::Vector2d>& path, const Wall& like) {
  std::vector<Wall> walls;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    Wall wall = like;
    wall.p = path[i];
    wall.q = path[i + 1];
    walls.push_back(wall);
  }
  const auto join = [&](Wall& a, Wall& b) {
    const double extension = corner_extension(a.direction(), b.direction(), like.thickness);
    a.extend_q = extension;
    b.extend_p = extension;
  };
  for (std::size_t i = 0; i + 1 < walls.size(); ++i) join(walls[i], walls[i + 1]);
  if (walls.size() > 2 && (path.front() - path.back()).norm() < 1e-6) join(walls.back(), walls.front());
  return walls;
}

std::string cut_opening(std::vector<Wall>& walls, const Eigen::Vector2d& at, double width, Opening opening) {
  Wall* found = nullptr;
  std::ostringstream where;
  where << "at (" << at.x() << ", " << at.y() << ")";
  for (Wall& wall : walls) {
    const Eigen::Vector2d offset = at - wall.p;
    const double along = offset.dot(wall.direction());
    if (std::abs(cross(wall.direction(), offset)) > 0.5 * wall.thickness + 0.02 || along < 0 || along > wall.length()) continue;
    if (found != nullptr) return "two walls meet " + where.str();
    found = &wall;
  }
  if (found == nullptr) return "no wall passes " + where.str();
  const double along = (at - found->p).dot(found->direction());
  opening.begin = along - 0.5 * width;
  opening.end = along + 0.5 * width;
  if (opening.begin < 0 || opening.end > found->length()) return "the opening " + where.str() + " goes beyond the end of its wall";
  opening.top = std::min(opening.top, found->height);
  if (opening.top <= opening.bottom) return "the opening " + where.str() + " has its top below its bottom";
  for (const Opening& other : found->openings) {
    if (opening.begin < other.end && other.begin < opening.end) return "two openings overlap " + where.str();
  }
  found->openings.push_back(opening);
  std::sort(found->openings.begin(), found->openings.end(), [](const Opening& a, const Opening& b) { return a.begin < b.begin; });
  return {};
}

std::optional<Place> place_between_walls(const Storey& storey, const Eigen::Vector2d& at, double yaw, std::string& error) {
  Place place;
  place.yaw = yaw;
  place.z = storey.elevation;
  place.height = storey.height;
  double reach[4];
  for (int side = 0; side < 4; ++side) {
    const double angle = yaw + side * M_PI / 2;
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    const Wall* nearest = nullptr;
    reach[side] = 1e9;
    for (const Wall& wall : storey.walls) {
      const Eigen::Vector2d direction = wall.direction();
      const double across = cross(ray, direction);
      if (std::abs(across) < 1e-6) continue;
      const double distance = cross(wall.p - at, direction) / across;
      const double along = cross(wall.p - at, ray) / across;
      if (distance <= 0 || along < -wall.extend_p || along > wall.length() + wall.extend_q || distance >= reach[side]) continue;
      reach[side] = distance;
      nearest = &wall;
    }
    if (nearest == nullptr) {
      error = "no wall bounds it towards " + std::to_string(std::lround(angle * 180 / M_PI)) + " deg";
      return std::nullopt;
    }
    if (std::abs(ray.dot(nearest->direction())) > 0.02) {
      error = "the wall towards " + std::to_string(std::lround(angle * 180 / M_PI)) + " deg isn't at a right angle: set yaw_deg";
      return std::nullopt;
    }
    if (!nearest->glass) reach[side] -= 0.5 * nearest->thickness;
  }
  place.width = {reach[0] + reach[2], reach[1] + reach[3]};
  place.center = at + Eigen::Rotation2Dd(yaw) * Eigen::Vector2d(0.5 * (reach[0] - reach[2]), 0.5 * (reach[1] - reach[3]));
  return place;
}

std::vector<Eigen::Vector2d> bounding_outline(const std::vector<Wall>& walls) {
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (const Wall& wall : walls) {
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.5 * wall.thickness);
    low = low.cwiseMin(wall.p.cwiseMin(wall.q) - margin);
    high = high.cwiseMax(wall.p.cwiseMax(wall.q) + margin);
  }
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

std::vector<Eigen::Vector2d> footprint(const Block& block) {
  const Eigen::Vector2d center = block.center.head<2>();
  std::vector<Eigen::Vector2d> corners;
  if (block.round) {
    for (int i = 0; i < 16; ++i) {
      const double angle = block.yaw + 2 * M_PI * i / 16;
      corners.emplace_back(center + 0.5 * block.size.x() * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    return corners;
  }
  const Eigen::Vector2d x = 0.5 * block.size.x() * Eigen::Vector2d(std::cos(block.yaw), std::sin(block.yaw));
  const Eigen::Vector2d y = 0.5 * block.size.y() * left_of(Eigen::Vector2d(std::cos(block.yaw), std::sin(block.yaw)));
  return {center - x - y, center + x - y, center + x + y, center - x + y};
}

std::vector<WallPiece> pieces_of(const Wall& wall, bool panes) {
  std::vector<WallPiece> pieces;
  double at = -wall.extend_p;
  for (const Opening& opening : wall.openings) {
    if (panes && opening.pane) continue;
    if (opening.begin > at) pieces.push_back({at, opening.begin, 0, wall.height});
    if (opening.bottom > 0) pieces.push_back({opening.begin, opening.end, 0, opening.bottom});
    if (opening.top < wall.height) pieces.push_back({opening.begin, opening.end, opening.top, wall.height});
    at = opening.end;
  }
  const double end = wall.length() + wall.extend_q;
  if (end > at) pieces.push_back({at, end, 0, wall.height});
  return pieces;
}

}  // namespace sgraph::sim
