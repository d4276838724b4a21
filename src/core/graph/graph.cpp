#include "sgraph_slam/core/graph/graph.hpp"

#include <stdexcept>

#include "sgraph_slam/core/graph/value_checks.hpp"

namespace sgraph {
namespace {

template <class Key, class Value>
const Value* find_in(const std::map<Key, Value>& map, Key id) {
  const auto found = map.find(id);
  return found == map.end() ? nullptr : &found->second;
}

template <class Key, class Value>
void set_in(std::map<Key, Value>& map, Key id, const Value& value) {
  const auto found = map.find(id);
  if (found == map.end()) throw std::invalid_argument("Graph::set: no " + to_string(VariableId(id)));
  if (!valid(value)) throw std::invalid_argument("Graph::set: value of " + to_string(VariableId(id)) + " isn't finite or not of unit length");
  found->second = value;
}

template <class Key, class Value>
bool same_values(const std::map<Key, Value>& a, const std::map<Key, Value>& b) {
  if (a.size() != b.size()) return false;
  for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j) {
    if (i->first != j->first || !same(i->second, j->second)) return false;
  }
  return true;
}

bool operator==(const MergeRecord& a, const MergeRecord& b) {
  return a.kept == b.kept && same(a.plane, b.plane) && a.repointed == b.repointed && a.dropped == b.dropped;
}

bool same_records(const std::map<PlaneId, MergeRecord>& a, const std::map<PlaneId, MergeRecord>& b) {
  if (a.size() != b.size()) return false;
  for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j) {
    if (i->first != j->first || !(i->second == j->second)) return false;
  }
  return true;
}

}  // namespace

const Pose* Graph::find(KeyframeId id) const { return find_in(keyframes_, id); }
const Plane* Graph::find(PlaneId id) const { return find_in(planes_, id); }
const Room* Graph::find(RoomId id) const { return find_in(rooms_, id); }
const Corridor* Graph::find(CorridorId id) const { return find_in(corridors_, id); }
const Factor* Graph::find(FactorId id) const { return find_in(factors_, id); }

bool Graph::contains(const VariableId& id) const {
  return std::visit([this](auto typed) { return find(typed) != nullptr; }, id);
}

const std::set<FactorId>& Graph::factors_of(const VariableId& id) const {
  static const std::set<FactorId> none;
  const auto found = factors_of_.find(id);
  return found == factors_of_.end() ? none : found->second;
}

void Graph::note_edit(FactorId id) {
  constexpr std::size_t remembered = 4096;
  ++factors_edited_;
  edited_.push_back(id);
  if (edited_.size() > remembered) edited_.pop_front();
}

std::optional<std::set<FactorId>> Graph::factors_edited_since(std::int64_t count) const {
  const std::int64_t edits = factors_edited_ - count;
  if (edits < 0 || edits > static_cast<std::int64_t>(edited_.size())) return std::nullopt;
  return std::set<FactorId>(edited_.end() - static_cast<std::ptrdiff_t>(edits), edited_.end());
}

PlaneId Graph::representative(PlaneId id) const {
  for (auto record = merges_.find(id); record != merges_.end(); record = merges_.find(id)) id = record->second.kept;
  return id;
}

void Graph::set(KeyframeId id, const Pose& T_map_base) {
  set_in(keyframes_, id, T_map_base);
  ++keyframes_moved_;
}
void Graph::set(PlaneId id, const Plane& plane) { set_in(planes_, id, plane); }
void Graph::set(RoomId id, const Room& room) { set_in(rooms_, id, room); }
void Graph::set(CorridorId id, const Corridor& corridor) { set_in(corridors_, id, corridor); }

bool operator==(const Graph& a, const Graph& b) {
  return same_values(a.keyframes_, b.keyframes_) && same_values(a.planes_, b.planes_) && same_values(a.rooms_, b.rooms_) &&
         same_values(a.corridors_, b.corridors_) && a.factors_ == b.factors_ && same_records(a.merges_, b.merges_) &&
         a.next_plane_ == b.next_plane_ && a.next_room_ == b.next_room_ && a.next_corridor_ == b.next_corridor_ && a.next_factor_ == b.next_factor_;
}

}  // namespace sgraph
