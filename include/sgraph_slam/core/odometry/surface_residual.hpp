#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/stamp.hpp"

namespace sgraph {

/// How far a registered point lies from its surface in the local map. Directions are in the LiDAR's frame at the moment of the firing.
struct SurfaceResidual {
  Eigen::Vector3f direction;  ///< unit, from the sensor to the point
  Eigen::Vector3f normal;     ///< unit, of the surface, towards the sensor
  float range = 0;            ///< [m]
  float intensity = 0;        ///< as the sensor gives it
  std::uint16_t ring = 0;
  float residual = 0;  ///< of the point along the normal; positive: before the surface [m]
  float sigma = 0;     ///< standard deviation of the points that made the surface, along its normal [m]
};

/// Called with each accepted scan when its motion is final and before its points enter the map: residuals of its keypoints that match.
using ResidualSink = std::function<void(Stamp stamp, const std::vector<SurfaceResidual>& residuals)>;

}  // namespace sgraph
