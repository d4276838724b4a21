#include "sgraph_slam/core/eval/map_error.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "polygon.hpp"

namespace sgraph {
namespace {

constexpr double cell_size = 1.0;
constexpr double tall = 1e3;  // height of a wall whose truth tells none [m]

}  // namespace

const char* to_string(PlanSurface value) {
  switch (value) {
    case PlanSurface::none: return "none";
    case PlanSurface::wall: return "wall";
    case PlanSurface::floor: return "floor";
    case PlanSurface::ceiling: return "ceiling";
    case PlanSurface::column: return "column";
    case PlanSurface::furniture: return "furniture";
    case PlanSurface::ground: return "ground";
  }
  return "?";
}

PlanSurfaces::PlanSurfaces(const Plan& plan, double reach) : reach_(reach), levels_(plan.levels), ground_(plan.ground) {
  for (const PlanWall& wall : plan.walls) add(wall);
  for (const PlanBlock& block : plan.blocks) {
    const auto surface = block.furniture ? PlanSurface::furniture : PlanSurface::column;
    solids_.push_back({block.center, 0.5 * block.size, {std::cos(block.yaw), std::sin(block.yaw)}, block.round, surface});
  }
  index();
}

void PlanSurfaces::add_box(const PlanWall& wall, double begin, double end, double bottom, double top, double thickness, double height) {
  if (end - begin < 1e-9 || top - bottom < 1e-9) return;
  const Eigen::Vector2d center = wall.p + 0.5 * (begin + end) * wall.direction();
  solids_.push_back({{center.x(), center.y(), wall.bottom + 0.5 * (bottom + top)},
                     {0.5 * (end - begin), 0.5 * thickness, 0.5 * (top - bottom)},
                     wall.direction(),
                     false,
                     PlanSurface::wall,
                     wall.lean,
                     wall.bottom + 0.5 * height,
                     wall.bow,
                     -0.5 * (begin + end),
                     wall.length()});
}

// The wall's body without its openings, as boxes: between the openings at full height, over and under each.
void PlanSurfaces::add(const PlanWall& wall) {
  const double height = std::min(wall.height, tall);
  const double thickness = wall.glass ? 0 : wall.thickness;
  double begin = -wall.extend_p;
  for (const PlanOpening& o : wall.openings) {
    const double top = std::min(o.top, height);
    add_box(wall, begin, o.begin, 0, height, thickness, height);
    add_box(wall, o.begin, o.end, 0, o.bottom, thickness, height);
    add_box(wall, o.begin, o.end, top, height, thickness, height);
    if (o.pane) add_box(wall, o.begin, o.end, o.bottom, top, 0, height);
    begin = o.end;
  }
  add_box(wall, begin, wall.length() + wall.extend_q, 0, height, thickness, height);
}

void PlanSurfaces::index() {
  if (solids_.empty()) return;
  std::vector<Eigen::AlignedBox2d> boxes;
  Eigen::AlignedBox2d all;
  for (const Solid& s : solids_) {
    const Eigen::Vector2d x = s.axis;
    const Eigen::Vector2d y(-x.y(), x.x());
    const double half_y = s.round ? s.half.x() : s.half.y();
    const Eigen::Vector2d half = (x * s.half.x()).cwiseAbs() + (y * half_y).cwiseAbs() + Eigen::Vector2d::Constant(reach_);
    boxes.emplace_back(s.center.head<2>() - half, s.center.head<2>() + half);
    all.extend(boxes.back());
  }
  origin_ = all.min();
  const Eigen::Vector2d size = all.sizes();
  columns_ = static_cast<int>(size.x() / cell_size) + 1;
  rows_ = static_cast<int>(size.y() / cell_size) + 1;
  cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Eigen::Vector2i low = ((boxes[i].min() - origin_) / cell_size).cast<int>();
    const Eigen::Vector2i high = ((boxes[i].max() - origin_) / cell_size).cast<int>();
    for (int row = low.y(); row <= std::min(high.y(), rows_ - 1); ++row) {
      for (int column = low.x(); column <= std::min(high.x(), columns_ - 1); ++column) {
        cells_[static_cast<std::size_t>(row * columns_ + column)].push_back(static_cast<int>(i));
      }
    }
  }
}

double PlanSurfaces::distance(const Solid& solid, const Eigen::Vector3d& p) {
  const Eigen::Vector3d r = p - solid.center;
  Eigen::Vector3d beyond;  // how far outside in each direction, negative inside
  if (solid.round) {
    beyond = {r.head<2>().norm() - solid.half.x(), -tall, std::abs(r.z()) - solid.half.z()};
  } else {
    const double x = r.head<2>().dot(solid.axis);
    const double share = 2 * (x - solid.from) / solid.length - 1;
    const double off_plan = solid.lean * (p.z() - solid.lean_height) + solid.bow * std::max(0.0, 1 - share * share);
    const double y = solid.axis.x() * r.y() - solid.axis.y() * r.x() - off_plan;
    beyond = Eigen::Vector3d(std::abs(x), std::abs(y), std::abs(r.z())) - solid.half;
  }
  const double outside = beyond.cwiseMax(0).norm();
  return outside > 0 ? outside : -beyond.maxCoeff();
}

SurfaceDistance PlanSurfaces::nearest(const Eigen::Vector3d& p) const {
  SurfaceDistance best{PlanSurface::none, reach_};
  const auto offer = [&best](PlanSurface surface, double distance) {
    if (distance < best.distance || (best.surface == PlanSurface::none && distance == best.distance)) best = {surface, distance};
  };
  for (const PlanLevel& level : levels_) {
    if (!contains(level.outline, p.head<2>())) continue;
    if (level.has_floor) offer(PlanSurface::floor, std::abs(p.z() - level.floor - level.floor_shape(p.head<2>())));
    if (level.ceiling) offer(PlanSurface::ceiling, std::abs(p.z() - *level.ceiling - level.ceiling_shape(p.head<2>())));
  }
  if (ground_) offer(PlanSurface::ground, std::abs(p.z() - *ground_));
  const Eigen::Vector2d cell = (p.head<2>() - origin_) / cell_size;
  if (cell.minCoeff() >= 0 && cell.x() < columns_ && cell.y() < rows_) {
    const auto index = static_cast<std::size_t>(static_cast<int>(cell.y()) * columns_ + static_cast<int>(cell.x()));
    for (const int i : cells_[index]) offer(solids_[static_cast<std::size_t>(i)].surface, distance(solids_[static_cast<std::size_t>(i)], p));
  }
  return best;
}

MapError map_error(const std::vector<Eigen::Vector3f>& points, const Pose& T_truth_map, const Plan& plan, double cap) {
  const PlanSurfaces surfaces(plan, cap);
  const auto height_unknown = [&plan](const Eigen::Vector3d& p) {
    return std::any_of(plan.levels.begin(), plan.levels.end(), [&p](const PlanLevel& level) {
      return !level.ceiling_known && p.z() >= level.floor + 2 && contains(level.outline, p.head<2>());
    });
  };
  const auto in_a_place = [&plan](const Eigen::Vector3d& p) {
    const auto holds = [&p](const PlanPlace& place) {
      const Eigen::Vector2d off = Eigen::Rotation2Dd(-place.yaw) * (p.head<2>() - place.center);
      return (off.cwiseAbs() - 0.5 * place.width).maxCoeff() < 0;
    };
    return std::any_of(plan.rooms.begin(), plan.rooms.end(), holds) || std::any_of(plan.corridors.begin(), plan.corridors.end(), holds);
  };
  MapError result;
  std::vector<double> all;
  std::vector<double> structure;
  std::vector<double> walls;
  std::vector<double> horizontal;
  std::vector<double> furniture;
  for (const Eigen::Vector3f& point : points) {
    ++result.points;
    const Eigen::Vector3d p = T_truth_map * point.cast<double>().eval();
    if (height_unknown(p)) {
      ++result.unknown_height;
      continue;
    }
    const SurfaceDistance found = surfaces.nearest(p);
    if (!plan.furniture_known && found.distance > ghost_distance && in_a_place(p)) {
      ++result.unknown_inside;
      continue;
    }
    all.push_back(found.surface == PlanSurface::none ? cap : found.distance);
    switch (found.surface) {
      case PlanSurface::none: ++result.beyond_cap; continue;
      case PlanSurface::ground: ++result.outdoors; continue;
      case PlanSurface::furniture: furniture.push_back(found.distance); continue;
      case PlanSurface::wall: walls.push_back(found.distance); break;
      case PlanSurface::floor:
      case PlanSurface::ceiling: horizontal.push_back(found.distance); break;
      case PlanSurface::column: break;
    }
    structure.push_back(found.distance);
  }
  if (!all.empty()) {
    const auto ghosts = std::count_if(all.begin(), all.end(), [](double distance) { return distance > ghost_distance; });
    result.ghost_share = static_cast<double>(ghosts) / static_cast<double>(all.size());
    result.p95 = quantile(std::move(all), 0.95);
  }
  result.structure = statistics_of(std::move(structure));
  result.walls = statistics_of(std::move(walls));
  result.horizontal = statistics_of(std::move(horizontal));
  result.furniture = statistics_of(std::move(furniture));
  return result;
}

}  // namespace sgraph
