#pragma once

#include "sgraph_slam/core/graph/marginals_cache.hpp"
#include "sgraph_slam/core/graph/odometry_drift.hpp"
#include "sgraph_slam/core/planes/association.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// How uncertain the map is about what a keyframe should see of its planes, for the chi-square gate. The odometry since a plane was last seen gives a
/// bound that costs nothing; where it is too wide to tell walls apart, the joint marginal covariance of the graph is taken.
class PlaneUncertainty {
 public:
  PlaneUncertainty(const Graph& graph, const PlaneMap& planes, const OdometryDrift& drift, MarginalsCache& cache, KeyframeId now);

  /// `J Sigma J^T` [rad, m].
  [[nodiscard]] Eigen::Matrix3d operator()(PlaneId id, const Innovation& innovation) const;

 private:
  [[nodiscard]] Eigen::Matrix3d by_odometry(const PlaneRecord& record, const Innovation& innovation) const;

  const Graph& graph_;
  const PlaneMap& planes_;
  const OdometryDrift& drift_;
  MarginalsCache& cache_;
  KeyframeId now_;
};

}  // namespace sgraph
