#pragma once

#include <string>
#include <variant>

#include <Eigen/Core>

#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/plane.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// Variables of the graph and their tangent spaces, in which covariances are given:
/// - keyframe: `T_map_base`; [rotation; translation] of `xi` in `T exp(xi)` (right perturbation, base frame) [rad, m];
/// - plane, map frame; [two angles in tangent_basis(normal); d] [rad, rad, m];
/// - room: [position; width]; corridor: [position, width] [m].
using VariableId = std::variant<KeyframeId, PlaneId, RoomId, CorridorId>;

/// A room: four walls. Estimated are `position` and `width`; the axes and the height at which tilted walls are met are constants.
struct Room {
  double yaw = 0;                                      ///< constant: of the room's x axis in the map [rad]
  double z = 0;                                        ///< constant: height of the centre in the map [m]
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< of the centre along the room's x and y axes, from the map's origin [m]
  Eigen::Vector2d width = Eigen::Vector2d::Zero();     ///< along the room's x and y [m]

  /// The room with this centre in the map frame.
  static Room at(const Eigen::Vector3d& center, double yaw, const Eigen::Vector2d& width);
  /// Unit vector of the room's axis 0 (x) or 1 (y) in the map.
  [[nodiscard]] Eigen::Vector3d axis(int index) const;
  /// Map frame [m].
  [[nodiscard]] Eigen::Vector3d center() const;
};

/// A corridor: two walls facing each other. Estimated are `position` and `width`; the rest are constants.
struct Corridor {
  double yaw = 0;       ///< constant: of the direction along the corridor in the map [rad]
  double along = 0;     ///< constant: of the centre along that direction, from the map's origin; no factor holds it [m]
  double z = 0;         ///< constant: height of the centre in the map [m]
  double position = 0;  ///< of the centre line across, to the left of the direction, from the map's origin [m]
  double width = 0;     ///< between the walls [m]

  static Corridor at(const Eigen::Vector3d& center, double yaw, double width);
  /// Unit vectors in the map: along the corridor, and across to the left hand.
  [[nodiscard]] Eigen::Vector3d direction() const;
  [[nodiscard]] Eigen::Vector3d across() const;
  /// Map frame [m].
  [[nodiscard]] Eigen::Vector3d center() const;
};

bool operator==(const Room& a, const Room& b);
bool operator==(const Corridor& a, const Corridor& b);

/// Degrees of freedom: 6, 3, 4, 2.
int tangent_size(const VariableId& id);
/// "keyframe", "plane", "room", "corridor".
const char* type_name(const VariableId& id);
/// "plane/7".
std::string to_string(const VariableId& id);

}  // namespace sgraph
