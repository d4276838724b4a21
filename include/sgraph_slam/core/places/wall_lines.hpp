#pragma once

#include <vector>

#include "sgraph_slam/core/places/free_space.hpp"
#include "sgraph_slam/core/planes/wall.hpp"

namespace sgraph {

/// A stretch of a wall line that rays pass close to the floor: a door, a passage, the end of a wall in the middle of a hall.
struct Gap {
  Interval along;         ///< along the line's direction [m]
  bool low_jamb = false;  ///< something ends it at its low end: wall, or another wall that crosses
  bool high_jamb = false;
  bool cut = false;  ///< places end here
};

/// Faces of walls that lie in one line and look the same way.
struct WallLine {
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  ///< of the best known face: unit, into the free space
  double offset = 0;                                  ///< `normal . p + offset = 0` [m]
  std::vector<std::size_t> faces;                     ///< indices among the walls, the best known first
  Intervals support;                                  ///< where a face has been seen [m]
  Intervals solid;                                    ///< where the line bounds: support and what is hidden, without the gaps
  std::vector<Gap> gaps;

  /// Unit vector along the line, to the left of the normal.
  [[nodiscard]] Eigen::Vector2d direction() const { return {-normal.y(), normal.x()}; }
  [[nodiscard]] Eigen::Vector2d at(double along) const { return along * direction() - offset * normal; }
  [[nodiscard]] double distance(const Eigen::Vector2d& p) const { return normal.dot(p) + offset; }
};

/// How far a wall's figures are to be trusted for the number of its views, 0..1.
double trust(const Wall& wall);

/// Way from a point along a unit vector to the nearest solid stretch of a line that looks at it [m]; infinite where there is none.
double way_to_face(const std::vector<WallLine>& lines, const Eigen::Vector2d& from, const Eigen::Vector2d& direction);

/// The lines of the walls that can bound a place, with their gaps. What stands before a wall and hides it (wardrobes, shelves) makes none.
std::vector<WallLine> find_wall_lines(const std::vector<Wall>& walls, const FreeSpace& space, const std::vector<Eigen::Vector2d>& path,
                                      const PlaceParams& params);

}  // namespace sgraph
