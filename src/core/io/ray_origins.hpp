#pragma once

#include <algorithm>
#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// Where the rays of a cloud came from, in the map.
class RayOrigins {
 public:
  RayOrigins(const Cloud& cloud, const Pose& T_map_lidar) : own_(T_map_lidar.translation) {
    for (const Viewpoint& view : cloud.viewpoints) views_.push_back({view.time, T_map_lidar * view.position});
  }

  [[nodiscard]] const Eigen::Vector3d& of(const Point& point) const {
    if (views_.empty()) return own_;
    const auto after = std::lower_bound(views_.begin(), views_.end(), point.time, [](const Viewpoint& v, double time) { return v.time < time; });
    if (after == views_.begin()) return after->position;
    const auto before = std::prev(after);
    return after == views_.end() || point.time - before->time < after->time - point.time ? before->position : after->position;
  }

 private:
  Eigen::Vector3d own_;
  std::vector<Viewpoint> views_;
};

}  // namespace sgraph
