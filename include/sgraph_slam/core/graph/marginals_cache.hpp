#pragma once

#include <memory>

#include "sgraph_slam/core/graph/marginals.hpp"

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
  std::shared_ptr<const Marginals> marginals_;  // never edited: copies of the cache share it
  KeyframeId newest_;
};

}  // namespace sgraph
