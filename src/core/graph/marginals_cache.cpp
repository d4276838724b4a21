#include "sgraph_slam/core/graph/marginals_cache.hpp"

namespace sgraph {

const Marginals* MarginalsCache::get(const Graph& graph, int max_age) {
  if (graph.keyframes().empty()) return nullptr;
  const KeyframeId latest = graph.keyframes().rbegin()->first;
  if (!marginals_ || latest.value - newest_.value > max_age) {
    marginals_ = std::make_shared<const Marginals>(graph);
    newest_ = latest;
  }
  return marginals_->ok() ? marginals_.get() : nullptr;
}

}  // namespace sgraph
