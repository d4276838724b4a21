#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sgraph {

/// A hole in a true wall: door, passage, or window when it holds a pane.
struct PlanOpening {
  double begin = 0;   ///< along the wall from its p [m]
  double end = 0;     ///< [m]
  double bottom = 0;  ///< above the wall's bottom [m]
  double top = 0;     ///< above the wall's bottom [m]
  bool pane = false;  ///< glass in it, along the wall's centre line
};

/// A true wall: a box about its centre line from p to q, with two faces half a thickness to either side.
struct PlanWall {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Eigen::Vector2d q = Eigen::Vector2d::Zero();
  double thickness = 0;
  double bottom = 0;                                        ///< [m]
  double height = std::numeric_limits<double>::infinity();  ///< infinite when the truth doesn't say
  double extend_p = 0;                                      ///< the body goes this far beyond p (or q) [m]
  double extend_q = 0;
  bool glass = false;  ///< one pane along the centre line
  double lean = 0;     ///< shift of the body to the left of p -> q with each metre of height; 0 at half height
  double bow = 0;      ///< of its middle to the left, as a parabola [m]
  std::vector<PlanOpening> openings;

  [[nodiscard]] double length() const { return (q - p).norm(); }
  [[nodiscard]] Eigen::Vector2d direction() const { return (q - p).normalized(); }
};

/// A column or a part of a piece of furniture: an upright box or, with `round`, a cylinder of diameter size.x.
struct PlanBlock {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  double yaw = 0;  ///< [rad]
  bool round = false;
  bool furniture = false;  ///< no part of the building
};

/// Height of an uneven floor or ceiling above its nominal one.
struct PlanShape {
  struct Wave {
    Eigen::Vector2d number = Eigen::Vector2d::Zero();  ///< [rad/m]
    double phase = 0;
    double amplitude = 0;  ///< [m]
  };
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  std::vector<Wave> waves;

  [[nodiscard]] double operator()(const Eigen::Vector2d& at) const;
};

/// Floor and ceiling of a storey.
struct PlanLevel {
  double floor = 0;  ///< z [m]
  bool has_floor = true;
  std::optional<double> ceiling;  ///< z [m]; nothing when there is none or the truth doesn't say
  bool ceiling_known = false;     ///< the truth says whether there is a ceiling
  PlanShape floor_shape;
  PlanShape ceiling_shape;
  std::vector<Eigen::Vector2d> outline;  ///< polygon
};

/// A true room or corridor: the rectangle between the faces of its walls.
struct PlanPlace {
  std::string name;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d width = Eigen::Vector2d::Zero();  ///< along its own x and y [m]
  double yaw = 0;                                   ///< of its own x axis [rad]
  double z = 0;                                     ///< floor [m]
  bool entered = true;                              ///< false: the robot at most looked in; to find it is neither asked for nor wrong
};

/// The building as it is, in the frame of the ground truth.
struct Plan {
  std::string name;
  std::vector<PlanWall> walls;
  std::vector<PlanBlock> blocks;
  bool furniture_known = true;  ///< false: the truth lists none, so what stands in a room can be anything
  std::vector<PlanLevel> levels;
  std::optional<double> ground;  ///< z around the building [m]
  std::vector<PlanPlace> rooms;
  std::vector<PlanPlace> corridors;
};

/// The panes in windows and glass doors, as upright boxes without thickness.
std::vector<PlanBlock> panes(const Plan& plan);

/// Reads truth.json: "walls" [{"p", "q", "t", "z", optional "height", "extend_p", "extend_q", "glass", "openings" [{"begin", "end", "bottom", "top",
/// "pane"}]}]; "rooms" and "corridors", and "other_rooms" and "other_corridors" that
/// the robot does not enter [{"id", "center", "width" and "yaw" or "polygon", whose first edge gives it}]; optional "columns" and
/// "furniture" [{"center", "size", "yaw", "round"}] and "storeys" [{"elevation", "height", "floor", "ceiling", "outline"}] and "ground". Without
/// storeys there is one floor a z of the walls, under all of them, and the ceiling counts as unknown. Throws std::runtime_error with file and key.
Plan read_plan(const std::string& path);

}  // namespace sgraph
