#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/io/occupancy_grid.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

using Segment2d = std::pair<Eigen::Vector2d, Eigen::Vector2d>;

/// One vertical plane seen from above.
struct DrawnWall {
  Segment2d line;                ///< its whole extent
  std::vector<Segment2d> solid;  ///< where there is an obstacle in the grid's band; between these are doors and what furniture hides
  bool low = false;              ///< not as high as a wall: furniture
};

/// A room or a corridor.
struct DrawnPlace {
  std::string name;  ///< "Room 3"; empty for corridors that are one piece of floor, whose parts have the names
  Eigen::Vector2d center;
  Eigen::Vector2d size;                  ///< along its own x and y [m]; a corridor's: length, width; a hall's: zero
  double area = 0;                       ///< [m^2]
  std::vector<Eigen::Vector2d> outline;  ///< counter-clockwise
  std::vector<std::vector<Eigen::Vector2d>> holes;
  bool corridor = false;
  bool part = false;  ///< of corridors that are one piece of floor: only its name is drawn
};

/// An opening between two places.
struct DrawnDoor {
  std::string name;  ///< "Door 2"
  Eigen::Vector2d center;
  double yaw = 0;     ///< of the direction through it [rad]
  double width = 0;   ///< [m]
  double height = 0;  ///< of its lintel; 0: not seen [m]
};

/// A building seen from above, in the map frame.
struct FloorPlan {
  double yaw = 0;  ///< of the walls: the drawing is turned by as much, at most 45 degrees, so that they lie along the page
  std::vector<DrawnWall> walls;
  std::vector<DrawnPlace> places;
  std::vector<DrawnDoor> doors;
  std::vector<Eigen::Vector2d> path;
  std::vector<Segment2d> obstacles;  ///< occupied cells, joined in rows: first and last cell's centre
  std::vector<Segment2d> free;       ///< free cells in the same way
  double cell = 0.05;                ///< edge of the cells [m]
};

FloorPlan make_floor_plan(const GraphSnapshot& snapshot, const OccupancyGrid& grid, const Trajectory& path);

/// The plan as a drawing: walls, places with names and sizes, path, scale bar. The longer side of the picture is 1600 pixels.
std::string floor_plan_svg(const FloorPlan& plan);
/// The plan for a CAD program (DXF of AutoCAD R12, metres): layers WALLS (both faces of each wall, open at doors), DOORS (sill lines and swings),
/// PLACES (outlines), LABELS (names, areas and sizes).
std::string floor_plan_dxf(const FloorPlan& plan);
/// The same as a PNG file's bytes.
std::string floor_plan_png(const FloorPlan& plan);

}  // namespace sgraph
