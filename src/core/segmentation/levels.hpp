#pragma once

#include <vector>

#include "extraction.hpp"

namespace sgraph {

/// Drops the parts of a surface that lie on another level than most of it: a shelf's back a hand's breadth before the wall, a wall that goes on a
/// little set back. Their points are within the noise's limit of a plane between the levels, which would be the least-squares plane of both. The
/// surface is fitted anew without them and no longer covers their place. False, and nothing changed, when there are none.
bool drop_other_levels(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const Limits& limits, FlatSurface& surface);

}  // namespace sgraph
