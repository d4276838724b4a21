#include "sgraph_slam/core/search/layout_builder.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace sgraph {
namespace {

constexpr double least_length = 0.4;  // of a piece of wall [m]

}  // namespace

void Upward::add(const Eigen::Vector3d& normal, double area) {
  if (std::abs(normal.z()) > std::cos(LayoutBuilder::tilt)) sum_ += (normal.z() > 0 ? area : -area) * normal;
}

Eigen::Quaterniond Upward::level() const {
  return sum_.norm() > 0.5 ? Eigen::Quaterniond::FromTwoVectors(sum_.normalized(), Eigen::Vector3d::UnitZ()) : Eigen::Quaterniond::Identity();
}

void LayoutBuilder::add_plane(PlaneId id, const Plane& plane, const std::vector<View>& views, std::size_t fewest) {
  const Plane level_plane = T_level_ * plane;
  std::vector<Outline> outlines;
  outlines.reserve(views.size());
  for (const View& seen : views) {
    const Pose T_level_base = T_level_ * seen.T_map_base;
    outlines.push_back(moved_outline(T_level_base, *seen.outline_base));
    const auto view = make_wall(id, level_plane, {outlines.back()}, tilt, wall_gap);
    if (view && view->height >= least_view_height) add_sight(*view, (T_level_base * T_base_lidar_).translation);
  }
  const auto wall = make_wall(id, level_plane, outlines, tilt, wall_gap);
  if (wall && wall->height >= least_height && outlines.size() >= fewest) add_pieces(*wall);
}

void LayoutBuilder::add_segment(const Plane& plane_lidar, const Outline& outline_lidar, const Pose& T_map_base) {
  const Pose T_level_lidar = T_level_ * T_map_base * T_base_lidar_;
  const auto view = make_wall({}, T_level_lidar * plane_lidar, {moved_outline(T_level_lidar, outline_lidar)}, tilt, wall_gap);
  if (!view || view->height < least_view_height) return;
  add_pieces(*view);
  add_sight(*view, T_level_lidar.translation);
}

void LayoutBuilder::add_pieces(const Wall& wall) {
  for (const Interval& part : wall.support) {
    if (part.length() >= least_length) pieces_.push_back({wall.at(part.low), wall.at(part.high), wall.normal});
  }
}

void LayoutBuilder::add_sight(const Wall& view, const Eigen::Vector3d& sensor) {
  const Interval whole = hull(view.support);
  if (view.distance(sensor.head<2>()) > 0) sights_.push_back({sensor.head<2>(), view.at(whole.low), view.at(whole.high)});
}

}  // namespace sgraph
