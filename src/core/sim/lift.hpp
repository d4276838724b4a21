#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/sim/world.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph::sim {

/// Where a ray meets the cabin or a landing's door.
struct LiftHit {
  double distance = 0;  ///< [m]; infinity: nothing
  double cosine = 0;    ///< of the angle of incidence, 0..1
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// A lift at work: cabin and doors move with the robot's route. The cabin is on the floor that is nearest to the robot, unless the robot rides in it.
/// The doors stand open there while the robot is near, and are shut from a second before a ride to half a second after it; on other floors they are
/// shut.
class LiftTrack {
 public:
  LiftTrack(const World& world, std::size_t lift, const std::function<Pose(double)>& motion);

  /// Sets the moment of the rays that follow [s].
  void move_to(double time);
  /// Nearest hit of a ray (unit direction).
  [[nodiscard]] LiftHit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  [[nodiscard]] double cabin_floor() const { return floor_; }
  /// Of the doors on the cabin's floor: 0 shut, 1 open.
  [[nodiscard]] double open() const { return open_; }

 private:
  struct Rectangle {  // at right angles to an axis
    int axis;
    double at;
    Eigen::Vector2d low, high;  // along the next two axes, in cyclic order
  };

  void add_doorway(double plane, double bottom, double open, bool frame, double top);
  [[nodiscard]] bool rides_at(double time) const;

  Lift lift_;
  double base_height_;
  std::function<Pose(double)> motion_;
  double time_ = -1;
  double floor_ = 0;
  double open_ = 1;
  std::vector<Rectangle> rectangles_;
};

}  // namespace sgraph::sim
