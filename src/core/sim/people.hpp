#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// Where somebody is at one moment.
struct PersonState {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
  double stride = 0;  ///< of one leg ahead of the body, the other as far behind [m]
};

/// A person's walk along the path, there and back, for ever.
class PersonTrack {
 public:
  PersonTrack(const Person& person);  // NOLINT(google-explicit-constructor): a vector of tracks is made from one of people

  [[nodiscard]] PersonState at(double time) const;
  [[nodiscard]] const Person& person() const { return person_; }

 private:
  Person person_;
  double length_ = 0;
};

/// Distance along a ray (unit direction) to a person's body: torso and legs as upright cylinders, head as a ball; infinity when it passes.
/// `cosine`, set with a hit, is that of the angle of incidence.
double distance_to_person(const Person& person, const PersonState& state, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                          double& cosine);

}  // namespace sgraph::sim
