#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// A beam of a spinning LiDAR as its points show it: they lie on the cone z = slope * hypot(x, y) + offset.
struct RingCone {
  double slope = 0;     ///< tangent of the elevation
  double offset = 0;    ///< height of the beam's origin on the axis [m]
  double residual = 0;  ///< rms of the points about the cone [m]
  double wobble = 0;    ///< standard deviation of the elevation seen from the origin [rad]
  int points = 0;
};

/// The beams of a spinning LiDAR, the lowest first.
struct RingTable {
  std::vector<RingCone> cones;   ///< by row
  std::vector<int> row_of_ring;  ///< by the cloud's ring number; -1: no such ring. Empty when the cloud numbers none
  bool sharp = false;            ///< the points lie on their cones to a few millimetres: the cloud is as the sensor saw it
  bool from_one_point = false;   ///< all beams start at the origin, to the precision of the numbers

  [[nodiscard]] int rows() const { return static_cast<int>(cones.size()); }
  /// Row whose cone is nearest to the point; -1 in an empty table.
  [[nodiscard]] int nearest_row(const Point& point) const;
};

/// The beams by their ring numbers. Nothing when the cloud has fewer than two rings with points enough to tell.
std::optional<RingTable> table_by_ring(const Cloud& cloud);

/// The beams by clusters of elevation, for clouds without ring numbers. Nothing when the elevations fall into no clear clusters: no spinning LiDAR,
/// or a cloud that was moved, thinned or put together.
std::optional<RingTable> table_by_elevation(const Cloud& cloud);

/// Name of the sensor with that table, as far as angles and offsets tell: "VLP-16" (also Puck LITE), "VLP-16 Hi-Res", "VLP-32C", "HDL-32E", "RS-16",
/// "XT-32", "Ouster, 64 rings", "unknown, 40 rings".
std::string model_of(const RingTable& table);

/// Time between two firings of the same laser of that model [s]; nothing for one that isn't known.
std::optional<double> firing_interval_of(const std::string& model);

/// Height of each laser's origin on the axis of a VLP-16 [m], the lowest ring first (VLP-16 User Manual 63-9243, table 9-1). The ROS driver's
/// calibration file has zeros there.
const std::vector<double>& vlp16_vertical_offsets();

}  // namespace sgraph
