#pragma once

#include <array>
#include <vector>

#include "sgraph_slam/core/places/oriented_rectangle.hpp"
#include "sgraph_slam/core/places/place_outline.hpp"

namespace sgraph {

enum class PlaceKind {
  room,      ///< two facing pairs of walls about a rectangle (paper, Topological Layer)
  corridor,  ///< one facing pair, long and narrow
  hall,      ///< any other outline
};

/// A piece of floor that a robot has been in.
struct FoundPlace {
  PlaceKind kind = PlaceKind::hall;
  PlaceOutline outline;
  OrientedRectangle area;        ///< room: between its walls; corridor: x along it; hall: the rectangle around it along its longest side
  std::array<PlaneId, 4> walls;  ///< room: at -x, +x, -y, +y; corridor: the first two, at the right and the left hand; hall: none

  /// The centre of a room or corridor; of a hall the inner point furthest from its outline.
  [[nodiscard]] Eigen::Vector2d reference_point() const {
    return kind == PlaceKind::hall ? inner_point(outline.polygon, hole_polygons(outline)) : area.center;
  }

  /// Whether it is a room or corridor of the paper, with a node of the graph. A hall is its outline: corners where faces meet move with the planes.
  [[nodiscard]] bool has_node() const { return kind != PlaceKind::hall; }
};

/// An opening between two places, or out of one to where the robot has not been.
struct FoundDoor {
  static constexpr std::size_t nowhere = static_cast<std::size_t>(-1);

  std::array<std::size_t, 2> places{};  ///< indices among the places, the lower one first; the second may be `nowhere`
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0;     ///< of the direction through it, from the first place to the second [rad]
  double width = 0;   ///< between its jambs [m]
  double height = 0;  ///< of its lintel above the floor [m]; 0: not seen
  double depth = 0;   ///< thickness of the wall; 0: only one of its faces is known [m]
};

/// Corridors that cross, fork or bend into one another, or one with niches: one piece of floor.
struct FoundBranching {
  PlaceOutline outline;
  std::vector<std::size_t> parts;  ///< its corridors, by their number among the places
};

struct FoundPlaces {
  std::vector<FoundPlace> places;
  std::vector<FoundBranching> branchings;
  std::vector<FoundDoor> doors;
};

/// Width, position and height of a door from the points on its jambs and lintel; as the raster has them where too few points are.
void measure_door(const FreeSpace& space, FoundDoor& door);

/// All places of a storey that the path entered, and the doors between them, as the walls and the free space are now. A function of its arguments
/// alone. `reference_yaw` [rad] tells which of the possible headings is a place's x axis: rooms take the nearest, corridors that within (-45, 135]
/// degrees.
FoundPlaces find_places(const FreeSpace& space, const std::vector<Wall>& walls, const std::vector<Eigen::Vector2d>& path, double reference_yaw,
                        const PlaceParams& params);

}  // namespace sgraph
