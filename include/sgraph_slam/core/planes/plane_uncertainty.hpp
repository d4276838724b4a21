#pragma once

#include <memory>

#include "sgraph_slam/core/graph/marginals.hpp"
#include "sgraph_slam/core/planes/association.hpp"
#include "sgraph_slam/core/planes/odometry_drift.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// The graph's covariances, factored when they are first asked for and kept for a few keyframes: between, the odometry tells how uncertainty grows.
class MarginalsCache {
 public:
  /// Of the graph now, or of at most `max_age` keyframes ago. Null when the factors don't determine the variables.
  const Marginals* get(const Graph& graph, int max_age);
  /// The newest keyframe that they know.
  [[nodiscard]] KeyframeId newest() const { return newest_; }
  /// After a change that moved more than the newest keyframes.
  void forget() { marginals_.reset(); }

 private:
  std::unique_ptr<Marginals> marginals_;
  KeyframeId newest_;
};

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
