#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/math/outline_area.hpp"
#include "sgraph_slam/core/types/plane.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// Convex outline of a surface on its plane, counter-clockwise about the normal.
using Outline = std::vector<Eigen::Vector3d>;

/// Convex hull of the points' projections on the plane. At most `max_corners` corners are kept: those that cut the least area go first. Fewer than
/// three corners when the points lie on a line.
Outline convex_outline(const Plane& plane, const std::vector<Eigen::Vector3d>& points, std::size_t max_corners = 24);

/// The outline that holds both.
Outline grown_outline(const Plane& plane, const Outline& outline, const std::vector<Eigen::Vector3d>& points, std::size_t max_corners = 24);

/// Shortest distance on the plane between two convex outlines [m]; 0 when they overlap, infinite when one is empty. Both are projected on the plane,
/// so they may come from two estimates of it.
double outline_distance(const Plane& plane, const Outline& a, const Outline& b);

/// The outline in another frame.
Outline moved_outline(const Pose& T_target_source, const Outline& outline);

/// Mean of the corners; zero for none.
Eigen::Vector3d outline_center(const Outline& outline);

}  // namespace sgraph
