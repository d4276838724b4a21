#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "point_set.hpp"
#include "sgraph_slam/core/math/outline_area.hpp"
#include "sgraph_slam/core/segmentation/params.hpp"

namespace sgraph {

/// Axes on a plane: `u` horizontal, `v` upwards (on a horizontal plane x and y, or nearly); u x v is the normal.
struct PlaneAxes {
  explicit PlaneAxes(const Eigen::Vector3f& normal);
  Eigen::Vector3f u, v;
  [[nodiscard]] Eigen::Vector2f operator()(const Eigen::Vector3f& p) const { return {u.dot(p), v.dot(p)}; }
};

/// Square cells on a plane. A point off the plane belongs to the cell it projects to.
struct PlaneCells {
  PlaneAxes axes;
  Eigen::Vector2f origin = Eigen::Vector2f::Zero();
  float edge = 0;
  int columns = 0, rows = 0;

  /// Row-major number of the cell; -1 outside.
  [[nodiscard]] int at(const Eigen::Vector3f& p) const {
    const Eigen::Vector2f q = (axes(p) - origin) / edge;
    const int column = static_cast<int>(std::floor(q.x()));
    const int row = static_cast<int>(std::floor(q.y()));
    return column < 0 || row < 0 || column >= columns || row >= rows ? -1 : row * columns + column;
  }
};

/// Connected part of the points on a plane.
struct Piece {
  std::vector<std::uint32_t> members;  ///< positions in the point set
  std::vector<int> cells;
  std::vector<Eigen::Vector2f> reach;  ///< of each of these cells along the axes, in cells
  Eigen::AlignedBox2f box;             ///< of the cells, along the axes
};

struct Pieces {
  PlaneCells cells;
  std::vector<Piece> pieces;  ///< in order of their first point
};

/// Splits points near a plane into pieces: cells whose distance is within one's reach are connected. A cell's reach up a wall is params.gap, or one
/// and a half rings at its range and incidence where that is more, at most params.max_gap; along the wall a fifth of these rings.
Pieces connected_pieces(const PointSet& points, const std::vector<std::uint32_t>& inliers, const PlaneF& plane, const SegmentationParams& params);

/// Distance between two boxes along the axes [m]; 0 when they touch.
inline float gap_between(const Eigen::AlignedBox2f& a, const Eigen::AlignedBox2f& b) { return a.exteriorDistance(b); }

/// Part of a plane that a segment covers: its pieces' cells and all within their reach, where a point would be connected to them.
struct Mask {
  PlaneCells cells;
  std::vector<char> set;
  [[nodiscard]] bool holds(const Eigen::Vector3f& p) const {
    const int cell = cells.at(p);
    return cell >= 0 && set[static_cast<std::size_t>(cell)] != 0;
  }
};
Mask mask_of(const PlaneCells& cells, const std::vector<const Piece*>& pieces);

/// Convex outline of points on a plane, counter-clockwise about its normal, within a hundredth of its height. Empty for fewer than three points.
std::vector<Eigen::Vector3d> outline(const PointSet& points, const std::vector<std::uint32_t>& which, const Plane& plane);

}  // namespace sgraph
