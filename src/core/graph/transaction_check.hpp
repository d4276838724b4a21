#pragma once

#include <map>
#include <set>
#include <string>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// Whether a transaction can be applied to a graph, found out without touching it.
class TransactionCheck {
 public:
  explicit TransactionCheck(const Graph& graph) : graph_(graph) {}

  /// Refusal::none, or the first thing that is wrong, with `detail()`.
  Refusal run(const Transaction& transaction);
  [[nodiscard]] const std::string& detail() const { return detail_; }

 private:
  Refusal check_undo(const std::vector<PlaneId>& planes);
  template <class Key, class Value>
  Refusal check_additions(const std::map<Key, Value>& additions);
  Refusal check_factors(const std::vector<Factor>& factors);
  Refusal check_removals(const Transaction& transaction);
  Refusal check_merges(const Transaction& transaction);

  [[nodiscard]] bool will_exist(const VariableId& id) const;
  Refusal refuse(Refusal refusal, const std::string& detail);

  const Graph& graph_;
  std::set<VariableId> added_;    // by the steps checked so far
  std::set<VariableId> removed_;  // likewise
  std::string detail_;
};

}  // namespace sgraph
