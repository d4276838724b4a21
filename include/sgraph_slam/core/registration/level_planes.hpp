#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/registration/surface_map.hpp"

namespace sgraph {

/// Floors and ceilings as whole planes, so that a floor ahead isn't laid down by the sensor's farthest ring alone. The rings of a spinning LiDAR are
/// off by millimetres in range and hundredths of a degree in elevation, each by its own. What the farthest ring shows of the floor ahead is matched
/// by nearer ones when the sensor gets there: in a corridor, where nothing else holds the pitch, each stretch of the floor leans against the last by
/// the same small angle, and the path climbs with the square of its length. A floor is level to millimetres over any distance, so a new piece of it
/// is put where the ring's error and the floor's own unevenness make it most likely.
class LevelPlanes {
 public:
  /// Takes planes from level surfaces of the map that lie on none that is known. `up`: unit vertical.
  void find(const std::vector<Surface>& surfaces, const Eigen::Vector3d& up);

  /// A point seen from `sensor`, moved along the vertical to where it most likely lies; the planes learn from it. `noise`: of its range [m].
  [[nodiscard]] Eigen::Vector3d settle(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, double noise);

  /// Fits the planes to what they have learnt.
  void update();

  [[nodiscard]] std::size_t size() const { return planes_.size(); }

 private:
  // height = slope . (p - origin) + height0, of p along the vertical.
  struct Plane {
    Eigen::Vector3d origin;
    Eigen::Vector3d coefficients;                           // slopes along two level axes, height at the origin
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // sum of w [x y 1]^T [x y 1], w = 1 a point
    Eigen::Vector3d right = Eigen::Vector3d::Zero();        // sum of w [x y 1]^T height
    double radius2 = 1;                                     // mean square distance of the points from their middle [m^2]
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();       // of these, [x y 1]
  };

  [[nodiscard]] Eigen::Vector3d coordinates(const Plane& plane, const Eigen::Vector3d& p) const;
  [[nodiscard]] double height(const Plane& plane, const Eigen::Vector3d& p) const { return up_.dot(p - plane.origin); }
  static void learn(Plane& plane, const Eigen::Vector3d& at, double height);
  static void fit(Plane& plane);

  std::vector<Plane> planes_;
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d x_ = Eigen::Vector3d::UnitX();
  Eigen::Vector3d y_ = Eigen::Vector3d::UnitY();
};

}  // namespace sgraph
