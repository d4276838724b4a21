#include "graph_edit.hpp"

#include <algorithm>

#include "transaction_check.hpp"

namespace sgraph {
namespace {

std::vector<PlaneId> planes_of(const FactorData& data) {
  std::vector<PlaneId> planes;
  for (const VariableId& id : blocks(data)) {
    if (const auto* plane = std::get_if<PlaneId>(&id)) planes.push_back(*plane);
  }
  return planes;
}

bool names(const FactorData& data, const VariableId& id) {
  const auto all = blocks(data);
  return std::find(all.begin(), all.end(), id) != all.end();
}

bool joins_a_plane_to_itself(const FactorData& data) {
  const auto planes = planes_of(data);
  return planes.size() == 2 && planes[0] == planes[1];
}

// Measurements may be many; statements about the building (this is the wall of that room, these two are parallel) count once.
bool is_statement(const FactorData& data) {
  return std::holds_alternative<RoomPlane>(data) || std::holds_alternative<CorridorPlane>(data) || std::holds_alternative<ParallelPlanes>(data) ||
         std::holds_alternative<PerpendicularPlanes>(data) || std::holds_alternative<WallThickness>(data) ||
         std::holds_alternative<AlignedWalls>(data);
}

bool same_statement(const FactorData& a, const FactorData& b) {
  if (a.index() != b.index()) return false;
  const auto of_a = blocks(a);
  const auto of_b = blocks(b);
  if (!std::is_permutation(of_a.begin(), of_a.end(), of_b.begin(), of_b.end())) return false;
  // Floors that two rides in a lift led between: each was measured.
  const auto* floors_a = std::get_if<AlignedWalls>(&a);
  if (floors_a != nullptr && floors_a->from == floors_a->to && floors_a->rise != std::get<AlignedWalls>(b).rise) return false;
  const auto* room_a = std::get_if<RoomPlane>(&a);
  const auto* room_b = std::get_if<RoomPlane>(&b);
  return room_a == nullptr || room_a->side == room_b->side;
}

}  // namespace

Applied Graph::apply(const Transaction& transaction) {
  TransactionCheck check(*this);
  Applied result;
  result.refusal = check.run(transaction);
  result.detail = check.detail();
  if (result.ok()) result.factors = GraphEdit(*this).run(transaction);
  return result;
}

std::vector<FactorId> GraphEdit::run(const Transaction& transaction) {
  for (const PlaneId plane : transaction.undo_merges) undo_merge(plane);
  graph_.keyframes_.insert(transaction.keyframes.begin(), transaction.keyframes.end());
  graph_.planes_.insert(transaction.planes.begin(), transaction.planes.end());
  graph_.rooms_.insert(transaction.rooms.begin(), transaction.rooms.end());
  graph_.corridors_.insert(transaction.corridors.begin(), transaction.corridors.end());
  const auto reserve = [](auto& next, const auto& additions) {
    if (!additions.empty()) next = std::max(next, additions.rbegin()->first.value + 1);
  };
  reserve(graph_.next_plane_, transaction.planes);
  reserve(graph_.next_room_, transaction.rooms);
  reserve(graph_.next_corridor_, transaction.corridors);
  std::vector<FactorId> added;
  for (const Factor& factor : transaction.factors) added.push_back(add_factor(factor));
  for (const FactorId id : transaction.remove_factors) forget(id);
  for (const VariableId& id : transaction.remove_variables) remove(id);
  for (const PlaneMerge& pair : transaction.merges) merge(pair);
  return added;
}

FactorId GraphEdit::add_factor(const Factor& factor) {
  const FactorId id{graph_.next_factor_++};
  insert(id, factor);
  return id;
}

void GraphEdit::insert(FactorId id, const Factor& factor) {
  if (!graph_.factors_.empty() && id < graph_.factors_.rbegin()->first) graph_.note_edit(id);
  graph_.factors_.emplace(id, factor);
  for (const VariableId& variable : blocks(factor.data)) graph_.factors_of_[variable].insert(id);
}

Factor GraphEdit::take_out(FactorId id) {
  graph_.note_edit(id);
  auto node = graph_.factors_.extract(id);
  for (const VariableId& variable : blocks(node.mapped().data)) {
    const auto of_variable = graph_.factors_of_.find(variable);
    of_variable->second.erase(id);
    if (of_variable->second.empty()) graph_.factors_of_.erase(of_variable);
  }
  if (is_view(node.mapped().data)) ++graph_.views_withdrawn_;
  return node.mapped();
}

void GraphEdit::forget(FactorId id) {
  take_out(id);
  for (auto& [plane, record] : graph_.merges_) record.repointed.erase(id);
}

void GraphEdit::remove(const VariableId& id) {
  const std::set<FactorId> factors = graph_.factors_of(id);
  for (const FactorId factor : factors) forget(factor);
  std::set<VariableId> gone{id};
  if (const auto* plane = std::get_if<PlaneId>(&id)) {  // what had been merged into it, also by way of others, goes with it
    for (const auto& [merged, record] : graph_.merges_) {
      if (graph_.representative(merged) == *plane) gone.insert(merged);
    }
    for (const VariableId& merged : gone) graph_.merges_.erase(std::get<PlaneId>(merged));
    graph_.planes_.erase(*plane);
  } else if (const auto* keyframe = std::get_if<KeyframeId>(&id)) {
    graph_.keyframes_.erase(*keyframe);
  } else if (const auto* room = std::get_if<RoomId>(&id)) {
    graph_.rooms_.erase(*room);
  } else {
    graph_.corridors_.erase(std::get<CorridorId>(id));
  }
  // An undo brings back no factor of what is gone.
  for (auto& [plane, record] : graph_.merges_) {
    for (auto dropped = record.dropped.begin(); dropped != record.dropped.end();) {
      const auto all = blocks(dropped->second.data);
      const bool names_gone = std::any_of(all.begin(), all.end(), [&gone](const VariableId& named) { return gone.count(named) > 0; });
      dropped = names_gone ? record.dropped.erase(dropped) : std::next(dropped);
    }
  }
}

bool GraphEdit::is_second_copy(const FactorData& data) const {
  if (!is_statement(data)) return false;
  const auto& others = graph_.factors_of(planes_of(data).front());
  return std::any_of(others.begin(), others.end(), [&](FactorId id) { return same_statement(graph_.factors_.at(id).data, data); });
}

void GraphEdit::merge(const PlaneMerge& merge) {
  MergeRecord record;
  record.kept = merge.kept;
  record.plane = graph_.planes_.at(merge.merged);
  const std::set<FactorId> factors = graph_.factors_of(merge.merged);
  for (const FactorId id : factors) {
    const Factor before = take_out(id);
    Factor after = before;
    after.data = repointed(before.data, merge.merged, merge.kept);
    if (joins_a_plane_to_itself(after.data) || is_second_copy(after.data)) {
      record.dropped.emplace(id, before);
    } else {
      insert(id, after);
      record.repointed.insert(id);
    }
  }
  graph_.planes_.erase(merge.merged);
  graph_.merges_.emplace(merge.merged, std::move(record));
}

Plane GraphEdit::restored_value(PlaneId plane, const MergeRecord& record) const {
  // The poses may have moved since the merge: the plane is where its first observation sees it now.
  for (const FactorId id : graph_.factors_of(plane)) {
    if (const auto* observation = std::get_if<PosePlane>(&graph_.factors_.at(id).data)) {
      return graph_.keyframes_.at(observation->keyframe) * observation->T_base_lidar * observation->measured;
    }
  }
  return record.plane;
}

void GraphEdit::undo_merge(PlaneId plane) {
  const MergeRecord record = graph_.merges_.at(plane);
  restore_repointed(plane, record);
  graph_.merges_.erase(plane);
  for (const auto& [id, factor] : record.dropped) restore_dropped(id, factor, plane);
  graph_.planes_[plane] = restored_value(plane, record);
}

void GraphEdit::restore_repointed(PlaneId plane, const MergeRecord& record) {
  // Where the plane's factors have been since: the planes it was merged into, one after the other.
  std::vector<PlaneId> chain{record.kept};
  while (graph_.merges_.count(chain.back()) > 0) chain.push_back(graph_.merges_.at(chain.back()).kept);
  for (const FactorId id : record.repointed) {
    for (const PlaneId link : chain) {
      const auto later = graph_.merges_.find(link);
      if (later == graph_.merges_.end()) continue;
      later->second.repointed.erase(id);
    }
    if (graph_.factors_.count(id) > 0) {
      Factor factor = take_out(id);
      factor.data = repointed(factor.data, chain.back(), plane);
      insert(id, factor);
      continue;
    }
    for (auto& [other, later] : graph_.merges_) {  // dropped by a later merge
      const auto dropped = later.dropped.find(id);
      if (dropped == later.dropped.end()) continue;
      Factor factor = dropped->second;
      later.dropped.erase(dropped);
      const auto link = std::find_if(chain.begin(), chain.end(), [&](PlaneId p) { return names(factor.data, p); });
      if (link != chain.end()) factor.data = repointed(factor.data, *link, plane);
      restore_dropped(id, factor, plane);
      break;
    }
  }
}

void GraphEdit::restore_dropped(FactorId id, Factor factor, PlaneId plane) {
  for (const PlaneId other : planes_of(factor.data)) {
    if (other == plane) continue;
    for (PlaneId link = other; graph_.merges_.count(link) > 0; link = graph_.merges_.at(link).kept) graph_.merges_.at(link).repointed.insert(id);
    factor.data = repointed(factor.data, other, graph_.representative(other));
  }
  insert(id, factor);
}

}  // namespace sgraph
