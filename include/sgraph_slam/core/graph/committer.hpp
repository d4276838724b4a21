#pragma once

#include <string>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/types/decision.hpp"

namespace sgraph {

/// The graph in the hands of a step of the mapping: edits go through here, and the log tells what was decided and why.
struct Committer {
  Graph& graph;
  DecisionLog& log;

  /// The newest keyframe; not valid before the first.
  [[nodiscard]] KeyframeId newest() const { return graph.keyframes().empty() ? KeyframeId{} : graph.keyframes().rbegin()->first; }

  /// Applies an edit, or logs why the graph refused it.
  Applied commit(const Transaction& transaction);

  /// Logs a proposal and what became of it, at the newest keyframe.
  void note(bool accepted, std::string what, std::string reason);
};

/// Appends a factor to an edit.
void add_factor(Transaction& edit, const FactorData& data, const RobustLoss& loss = {});

}  // namespace sgraph
