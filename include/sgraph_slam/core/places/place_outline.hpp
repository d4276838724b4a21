#pragma once

#include <optional>
#include <vector>

#include "sgraph_slam/core/places/polygon.hpp"
#include "sgraph_slam/core/places/regions.hpp"

namespace sgraph {

/// A side of a place: from its corner of the same number to the next.
struct PlaceSide {
  int line = -1;       ///< the wall line that it lies on, -1: none
  PlaneId plane;       ///< the face that shows most of it; invalid when none does
  double wall = 0;     ///< share of its length where wall has been seen
  double opening = 0;  ///< share of its length where a gap is
};

/// Corners and the sides between them.
struct PlaceLoop {
  Polygon2d polygon;
  std::vector<PlaceSide> sides;  ///< one a corner
};

/// A piece of floor with its outline.
struct PlaceOutline : PlaceLoop {
  std::vector<PlaceLoop> holes;  ///< what lies within it and isn't the place's: other places, shafts; clockwise
};

std::vector<Polygon2d> hole_polygons(const PlaceOutline& outline);

/// Whether a point lies inside, in no hole.
bool contains(const PlaceOutline& outline, const Eigen::Vector2d& p);

/// Without the holes [m^2].
double area(const PlaceOutline& outline);

/// The outline of a region: of the cells into which the wall lines beside it (and straight pieces of its border where no wall is known) cut the
/// floor, those that belong to it at the least cost: a free cell outside, a cell of another place or of a wall inside, and a border where no wall is
/// are paid for by their size. Furniture and what it hides goes with the cell that it stands in. Nothing for a region without extent.
std::optional<PlaceOutline> find_outline(const FreeSpace& space, const Regions& regions, int region, const std::vector<WallLine>& lines,
                                         const std::vector<Wall>& walls, const PlaceParams& params);

}  // namespace sgraph
