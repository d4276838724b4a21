#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/math/signed_area.hpp"

namespace sgraph {

/// Outline on the ground, counter-clockwise, the first corner not repeated.
using Polygon2d = std::vector<Eigen::Vector2d>;

/// Centre of gravity; the mean of the corners when the area is 0.
Eigen::Vector2d centroid(const Polygon2d& polygon);

/// Whether a point lies inside.
bool contains(const Polygon2d& polygon, const Eigen::Vector2d& p);

/// Distance of a point from the outline [m].
double distance_to_outline(const Polygon2d& polygon, const Eigen::Vector2d& p);

/// The part of a convex polygon where `normal . p + offset >= 0`; empty when there is none.
Polygon2d clipped(const Polygon2d& convex, const Eigen::Vector2d& normal, double offset);

/// The inner point furthest from the outline and the holes, to half a decimetre: where a label goes.
Eigen::Vector2d inner_point(const Polygon2d& polygon, const std::vector<Polygon2d>& holes = {});

}  // namespace sgraph
