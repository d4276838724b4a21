#pragma once

#include <optional>

#include "sgraph_slam/core/odometry/params.hpp"
#include "sgraph_slam/core/registration/level_planes.hpp"
#include "sgraph_slam/core/registration/surface_map.hpp"
#include "sgraph_slam/core/sensor/ring_calibration.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// The odometry's local map, and what is read from it.
class MapUpdater {
 public:
  explicit MapUpdater(const OdometryParams& params) : params_(params.map), leaf_(params.map_leaf), map_(params.map) {}

  /// Puts a deskewed scan's points into the map: one in a voxel of `map_leaf`, each with the normal that its scan shows.
  void insert(const Cloud& deskewed, const Pose& T_odom_lidar, Placing placing);
  void clear();
  /// Whether scans are kept from now on, for `correct`; no longer forgets them.
  void remember_scans(bool remember);
  /// Builds the map again, from the scans that are kept, without the errors of the beams.
  void correct(const RingCalibration& added);
  /// Looks for the vertical while it isn't known.
  void find_vertical();

  /// A map of one deskewed scan alone.
  [[nodiscard]] SurfaceMap map_of(const Cloud& deskewed, const Pose& T_map_lidar) const;

  [[nodiscard]] const SurfaceMap& map() const { return map_; }
  /// Standard deviation of a residual [m]: range noise, and what the map doesn't know.
  [[nodiscard]] double noise() const;
  /// Whether floors and ceilings have shown the building's vertical.
  [[nodiscard]] bool vertical_known() const { return vertical_.has_value(); }
  /// The building's vertical in odom, |up| = 1; that of the first scan's base until it is known.
  [[nodiscard]] Eigen::Vector3d up() const { return vertical_.value_or(Eigen::Vector3d::UnitZ()); }

 private:
  // What of a scan enters the map.
  struct Taken {
    std::vector<Point> points;  // LiDAR frame
    std::vector<std::optional<Eigen::Vector3f>> normals;
    Pose T_odom_lidar;
    Placing placing;
  };
  [[nodiscard]] Taken taken_from(const Cloud& deskewed, const Pose& T_odom_lidar, Placing placing) const;
  void insert(const Taken& scan);
  [[nodiscard]] bool shows_more(const Pose& T_odom_lidar) const;

  SurfaceMapParams params_;
  double leaf_;
  SurfaceMap map_;
  LevelPlanes level_;
  std::optional<Eigen::Vector3d> vertical_;
  int inserted_ = 0;             // scans
  std::size_t looked_at_ = 0;    // voxels of the map when planes were last looked for,
  std::size_t looked_from_ = 0;  // and the time before
  bool remembers_ = false;
  std::vector<Taken> kept_;
};

}  // namespace sgraph
