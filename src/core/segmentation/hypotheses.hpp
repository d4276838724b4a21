#pragma once

#include <vector>

#include "point_set.hpp"

namespace sgraph {

/// A plane fitted to a small neighbourhood.
struct Hypothesis {
  PlaneF plane;  ///< faces the viewpoints of its points
  Eigen::Vector3f centroid = Eigen::Vector3f::Zero();
  float rms = 0;     ///< of the neighbourhood's points on it [m]
  float cosine = 0;  ///< of the angle between its normal and the viewing ray
};

/// Hypotheses from at most `count` places, spread evenly over the surfaces: the neighbourhoods grow with the range (0.8 m to 6 m, 1.6 m to 12 m,
/// 3.2 m beyond), so that each holds several rings. Within each a least-median-of-squares search over point triples finds the plane of the
/// majority. Neighbourhoods without a flat majority give nothing.
std::vector<Hypothesis> sample_hypotheses(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, int count, RandomStream& random);

/// Standard deviation of the points about their planes [m]: the median over the neighbourhoods seen at less than 45 degrees, or over all when these
/// are few; `fallback` without any.
double estimate_noise(const std::vector<Hypothesis>& hypotheses, double fallback);

}  // namespace sgraph
