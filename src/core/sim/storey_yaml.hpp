#pragma once

#include <map>
#include <string>

#include "yaml_fields.hpp"

namespace sgraph::sim {

/// The frame in which a wing's points are given.
struct PlanFrame {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double yaw = 0;  ///< [rad]

  [[nodiscard]] Eigen::Vector2d operator*(const Eigen::Vector2d& p) const { return origin + Eigen::Rotation2Dd(yaw) * p; }
};

/// A storey's frames by the name of the wing; "" is the storey itself.
using PlanFrames = std::map<std::string, PlanFrame>;

/// Reads a storey's keys; leaves others for the caller. Throws WorldError.
Storey read_storey(Fields& fields, const std::string& name, PlanFrames& frames);

}  // namespace sgraph::sim
