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
};

/// A point cloud with one stamp and one frame. Shared as `CloudPtr` and never edited after hand-over.
struct Cloud {
  Stamp stamp;
  std::string frame;
  std::vector<Point> points;

  [[nodiscard]] std::size_t size() const { return points.size(); }
  [[nodiscard]] bool empty() const { return points.empty(); }
};

using CloudPtr = std::shared_ptr<const Cloud>;

}  // namespace sgraph
