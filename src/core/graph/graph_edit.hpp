#pragma once

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// Carries out a transaction that has passed TransactionCheck.
class GraphEdit {
 public:
  explicit GraphEdit(Graph& graph) : graph_(graph) {}

  std::vector<FactorId> run(const Transaction& transaction);

 private:
  FactorId add_factor(const Factor& factor);
  void insert(FactorId id, const Factor& factor);
  Factor take_out(FactorId id);
  void forget(FactorId id);  // takes it out for good, from the records of merges too
  void remove(const VariableId& id);
  void merge(const PlaneMerge& merge);
  void undo_merge(PlaneId plane);
  void restore_repointed(PlaneId plane, const MergeRecord& record);
  void restore_dropped(FactorId id, Factor factor, PlaneId plane);
  [[nodiscard]] bool is_second_copy(const FactorData& data) const;
  [[nodiscard]] Plane restored_value(PlaneId plane, const MergeRecord& record) const;

  Graph& graph_;
};

}  // namespace sgraph
