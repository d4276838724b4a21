#pragma once

#include <vector>

#include "sgraph_slam/core/places/regions.hpp"

namespace sgraph {

/// An opening wider than a door parts no floor where the line does not reach the ceiling: an aisle between rows of racks is no place of its own.
void join_over_low_lines(const FreeSpace& space, const PlaceParams& params, std::vector<WallLine>& lines);

/// A gap between a piece of furniture and the wall beside it, which leads to no more than what is left behind it, is no door: the line does not reach
/// the ceiling, and the floor behind it was not entered and is no deeper than furniture is. Returns whether there was such a gap.
bool join_recesses(const FreeSpace& space, const Regions& regions, std::vector<WallLine>& lines);

/// Drops the lines of what stands within a single place and does not reach the ceiling: racks, rows of cupboards, parked cars, screens. The floor of
/// the place runs all around it or as far as the wall behind it, and rays pass above it or between its parts. A room within a hall is entered, the
/// core of a building reaches the ceiling: both stay. `regions`: those of the lines. Returns whether there was such a line.
bool drop_islands(const FreeSpace& space, const Regions& regions, std::vector<WallLine>& lines);

}  // namespace sgraph
