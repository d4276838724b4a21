#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/stamp.hpp"

namespace sgraph {

/// One LiDAR return.
struct Point {
  float x = 0;
  float y = 0;
  float z = 0;             ///< position in the cloud's frame [m]
  float intensity = 0;     ///< as the sensor gives it; 0 when it gives none
  float time = 0;          ///< seconds from the cloud's stamp to this firing; negative when the cloud is stamped at its end; 0 when unknown
  std::uint16_t ring = 0;  ///< beam number, counted from the lowest; 0 when unknown

  [[nodiscard]] Eigen::Vector3f position() const { return {x, y, z}; }
  void set_position(const Eigen::Vector3f& p) { x = p.x(), y = p.y(), z = p.z(); }
};

/// Where the LiDAR was, in the cloud's frame, at `time` seconds from the cloud's stamp.
struct Viewpoint {
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// A point cloud with one stamp and one frame. Shared as `CloudPtr` and never edited after hand-over.
struct Cloud {
  Stamp stamp;
  std::string frame;
  std::vector<Point> points;
  std::vector<Viewpoint> viewpoints{};  ///< of a cloud put together from several scans: one a scan, in order of time; empty: seen from the origin

  [[nodiscard]] std::size_t size() const { return points.size(); }
  [[nodiscard]] bool empty() const { return points.empty(); }
};

using CloudPtr = std::shared_ptr<const Cloud>;

}  // namespace sgraph
