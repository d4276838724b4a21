#include "sgraph_slam/core/graph/committer.hpp"

#include <utility>

namespace sgraph {

Applied Committer::commit(const Transaction& transaction) {
  const Applied applied = graph.apply(transaction);
  if (!applied.ok()) note(false, transaction.reason, std::string(to_string(applied.refusal)) + ": " + applied.detail);
  return applied;
}

void Committer::note(bool accepted, std::string what, std::string reason) { log.push_back({newest(), accepted, std::move(what), std::move(reason)}); }

void add_factor(Transaction& edit, const FactorData& data, const RobustLoss& loss) {
  Factor& factor = edit.factors.emplace_back();
  factor.data = data;
  factor.loss = loss;
}

}  // namespace sgraph
