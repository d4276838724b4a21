#pragma once

#include <vector>

#include <Eigen/Core>

namespace sgraph {

using Polygon = std::vector<Eigen::Vector2d>;

/// Whether a simple polygon, turning either way, holds a point.
bool contains(const Polygon& polygon, const Eigen::Vector2d& p);

/// Area of a simple polygon [m^2], not negative.
double area(const Polygon& polygon);

/// Corners of a rectangle, counter-clockwise; widths along its own x and y, yaw of its x axis.
Polygon rectangle(const Eigen::Vector2d& center, const Eigen::Vector2d& width, double yaw);

/// The part of a polygon within a convex counter-clockwise one (Sutherland and Hodgman 1974).
Polygon clip(const Polygon& subject, const Polygon& convex);

}  // namespace sgraph
