#include "transaction_check.hpp"

#include "sgraph_slam/core/graph/value_checks.hpp"

namespace sgraph {

Refusal TransactionCheck::run(const Transaction& transaction) {
  Refusal refusal = check_undo(transaction.undo_merges);
  if (refusal == Refusal::none) refusal = check_additions(transaction.keyframes);
  if (refusal == Refusal::none) refusal = check_additions(transaction.planes);
  if (refusal == Refusal::none) refusal = check_additions(transaction.rooms);
  if (refusal == Refusal::none) refusal = check_additions(transaction.corridors);
  if (refusal == Refusal::none) refusal = check_factors(transaction.factors);
  if (refusal == Refusal::none) refusal = check_removals(transaction);
  if (refusal == Refusal::none) refusal = check_merges(transaction);
  return refusal;
}

Refusal TransactionCheck::refuse(Refusal refusal, const std::string& detail) {
  detail_ = detail;
  return refusal;
}

bool TransactionCheck::will_exist(const VariableId& id) const { return (graph_.contains(id) || added_.count(id) > 0) && removed_.count(id) == 0; }

Refusal TransactionCheck::check_undo(const std::vector<PlaneId>& planes) {
  for (const PlaneId id : planes) {
    if (graph_.merges().count(id) == 0) return refuse(Refusal::unknown_id, "undo: " + to_string(id) + " hasn't been merged");
    if (!added_.insert(id).second) return refuse(Refusal::duplicate_id, "undo: " + to_string(id) + " is named twice");
  }
  return Refusal::none;
}

template <class Key, class Value>
Refusal TransactionCheck::check_additions(const std::map<Key, Value>& additions) {
  for (const auto& [id, value] : additions) {
    const std::string name = to_string(VariableId(id));
    if (!id.valid()) return refuse(Refusal::duplicate_id, "add: " + name + " isn't an id");
    bool used = will_exist(id);
    if constexpr (std::is_same_v<Key, PlaneId>) used = used || graph_.merges().count(id) > 0;
    if (used) return refuse(Refusal::duplicate_id, "add: " + name + " exists");
    if (!valid(value)) return refuse(Refusal::not_finite, "add: value of " + name);
    added_.insert(id);
  }
  return Refusal::none;
}

Refusal TransactionCheck::check_factors(const std::vector<Factor>& factors) {
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const std::string name = std::string(type_name(factors[i].data)) + " (factor " + std::to_string(i) + " of the transaction)";
    if (!valid(factors[i])) return refuse(Refusal::not_finite, "add: " + name);
    std::set<VariableId> seen;
    for (const VariableId& id : blocks(factors[i].data)) {
      if (!will_exist(id)) return refuse(Refusal::unknown_id, "add: " + name + " names " + to_string(id) + ", which isn't in the graph");
      if (!seen.insert(id).second) return refuse(Refusal::invalid_factor, "add: " + name + " names " + to_string(id) + " twice");
    }
  }
  return Refusal::none;
}

Refusal TransactionCheck::check_removals(const Transaction& transaction) {
  std::set<FactorId> factors;
  for (const FactorId id : transaction.remove_factors) {
    if (graph_.find(id) == nullptr || !factors.insert(id).second) {
      return refuse(Refusal::unknown_id, "remove: factor " + std::to_string(id.value) + " isn't in the graph");
    }
  }
  for (const VariableId& id : transaction.remove_variables) {
    if (!will_exist(id)) return refuse(Refusal::unknown_id, "remove: " + to_string(id) + " isn't in the graph");
    removed_.insert(id);
  }
  return Refusal::none;
}

Refusal TransactionCheck::check_merges(const Transaction& transaction) {
  const auto value = [&](PlaneId id) {
    const auto added = transaction.planes.find(id);
    if (added != transaction.planes.end()) return added->second;
    const Plane* present = graph_.find(id);
    return present != nullptr ? *present : graph_.merges().at(id).plane;  // else restored by this very transaction
  };
  for (const PlaneMerge& merge : transaction.merges) {
    for (const PlaneId id : {merge.kept, merge.merged}) {
      if (!will_exist(id)) return refuse(Refusal::unknown_id, "merge: " + to_string(id) + " isn't in the graph");
    }
    if (merge.kept == merge.merged) return refuse(Refusal::invalid_factor, "merge: " + to_string(merge.kept) + " with itself");
    if (value(merge.kept).normal.dot(value(merge.merged).normal) <= 0) {
      return refuse(Refusal::opposed_planes, "merge: " + to_string(merge.kept) + " and " + to_string(merge.merged) + " face opposite sides");
    }
    removed_.insert(merge.merged);
  }
  return Refusal::none;
}

}  // namespace sgraph
