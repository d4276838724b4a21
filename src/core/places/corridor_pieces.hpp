#pragma once

#include <array>
#include <optional>
#include <vector>

#include "outline_sides.hpp"

namespace sgraph {

/// A straight piece of a corridor in an outline: between two facing sides.
struct CorridorPiece {
  Eigen::Vector2d axis;               ///< along it
  Interval along;                     ///< with what it reaches into at its ends
  Interval across;                    ///< to the left of the axis: from the right side to the left one
  std::array<std::size_t, 2> side{};  ///< of `all_sides` of the outline: right and left
  std::array<bool, 2> open{};         ///< low and high end

  [[nodiscard]] double length() const { return along.length(); }
  [[nodiscard]] double width() const { return across.length(); }
  [[nodiscard]] Eigen::Vector2d at(double s, double t) const { return s * axis + t * left_of(axis); }
};

OrientedRectangle rectangle_of(const CorridorPiece& piece);

/// The pieces of an outline that are long and narrow, the longest first. Over a corner or a crossing a piece goes on to the wall ahead; into a hall
/// it does not.
std::vector<CorridorPiece> corridor_pieces(const PlaceOutline& outline, const PlaceParams& params);

/// The corridor of a piece; nothing when a face is missing along it.
std::optional<FoundPlace> corridor_place(const CorridorPiece& piece, const PlaceOutline& outline, const std::vector<Wall>& walls,
                                         double reference_yaw);

/// Adds the lines where a piece ends in a hall or is open to its side: places are cut there, but not where another piece goes on.
void add_cuts(const CorridorPiece& piece, const std::vector<OrientedRectangle>& others, std::vector<WallLine>& lines);

}  // namespace sgraph
