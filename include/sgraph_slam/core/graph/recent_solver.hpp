#pragma once

#include <map>
#include <vector>

#include "sgraph_slam/core/graph/solver.hpp"

namespace sgraph {

/// Views of one plane from keyframes that stay where they are, summed: `1/2 (squared + 2 g . x + x^T Q x)` with `x = [n; d] - reference`. Exact for
/// frozen robust weights, as an observation is linear in the plane: ten numbers however many views.
struct FixedViews {
  Eigen::Vector4d reference = Eigen::Vector4d::Zero();  ///< near which the plane is
  Eigen::Matrix4d Q = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  double squared = 0;
  int count = 0;
};

/// Solves the newest keyframes with the planes they see, again and again as keyframes arrive. What older keyframes saw of these planes is kept as a
/// sum a plane, so that a solve costs what the newest keyframes hold, however often the planes have been seen before. The sums are made anew after
/// edits that take views away and after solves that move older keyframes. A copy goes on as the original would, to the bit.
class RecentSolver {
 public:
  /// Optimises in place what `recent_window(graph, count)` names; see solve() for the rest.
  SolveSummary solve(Graph& graph, int count, const SolverOptions& options);

 private:
  struct Seen {
    FixedViews views;
    FactorId last;                 // of the plane's factors, those up to it have been sorted in
    std::vector<FactorId> recent;  // views from the newest keyframes, not in the sum yet
    std::vector<FactorId> others;  // factors that are no views
  };

  void update(const Graph& graph, PlaneId id, KeyframeId oldest);

  std::map<PlaneId, Seen> seen_;
  std::int64_t withdrawn_ = 0;  // of the graph, when the sums were last right
  std::int64_t moved_ = 0;
};

}  // namespace sgraph
