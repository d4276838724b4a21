#pragma once

#include <map>
#include <optional>
#include <vector>

#include "sgraph_slam/core/planes/outline.hpp"
#include "sgraph_slam/core/search/place_search.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/scene.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// A keyframe and the planes seen in its cloud.
struct LocatedKeyframe {
  Keyframe keyframe;
  PlaneSegments segments;
};

/// A map, as what a robot that comes back to it is compared with. Never changed.
class ReferenceMap {
 public:
  struct Face {
    PlaneId id;
    Plane plane;  ///< map frame
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    Outline outline;  ///< map frame
  };

  /// `snapshot`: with the views of its planes. `T_base_lidar`: of the robot that made it.
  ReferenceMap(const GraphSnapshot& snapshot, const Pose& T_base_lidar);

  [[nodiscard]] const PlaceSearch& search() const { return search_; }
  [[nodiscard]] const std::vector<Face>& faces() const { return faces_; }
  /// Rotation that makes the map's floors level: the search works in the level frame.
  [[nodiscard]] const Eigen::Quaterniond& level() const { return level_; }
  /// Height of the base in the level frame where the nearest keyframe was [m]; 0 without keyframes.
  [[nodiscard]] double base_height(const Eigen::Vector2d& at_level) const;
  /// Upward-facing floor at a place of the level frame, nearest to a height: its height there [m].
  [[nodiscard]] std::optional<double> floor_height(const Eigen::Vector2d& at_level, double near) const;
  /// First pose of the newest session.
  [[nodiscard]] const Pose& first_pose() const { return first_pose_; }

 private:
  std::vector<Face> faces_;
  Eigen::Quaterniond level_;
  std::vector<Eigen::Vector3d> keyframes_;  // positions in the level frame
  Pose first_pose_;
  PlaceSearch search_;
};

/// What a robot has seen lately, from above: the walls and free space of these keyframes in its odometry's level frame.
struct Surroundings {
  Layout layout;
  Eigen::Quaterniond level;  ///< from the odometry's frame into the level one
};
Surroundings surroundings_of(const std::vector<LocatedKeyframe>& keyframes, const Pose& T_base_lidar);

/// The pose of the odometry in the map for a place found in the level frames: heights by the floors, or by the nearest keyframe.
Pose pose_from_place(const ReferenceMap& map, const Surroundings& surroundings, const std::vector<LocatedKeyframe>& keyframes,
                     const Pose& T_base_lidar, const Pose2d& T_map_query);

}  // namespace sgraph
