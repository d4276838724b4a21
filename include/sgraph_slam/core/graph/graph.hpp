#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>

#include "sgraph_slam/core/graph/factor.hpp"
#include "sgraph_slam/core/graph/transaction.hpp"

namespace sgraph {

/// What a merge changed, kept so that it can be undone.
struct MergeRecord {
  PlaneId kept;
  Plane plane;                         ///< of the merged one, at the time
  std::set<FactorId> repointed;        ///< factors that were the merged plane's
  std::map<FactorId, Factor> dropped;  ///< factors between the two, or second copies of one wall's place in a room
};

/// The ordered store of variables and factors: values only. Copies are independent; a long solve may work on one. Edited through transactions; the
/// solver writes new values of variables. Not thread-safe.
class Graph {
 public:
  /// Applies the edit as a whole, or refuses it and leaves the graph as it was.
  Applied apply(const Transaction& transaction);

  [[nodiscard]] const std::map<KeyframeId, Pose>& keyframes() const { return keyframes_; }  ///< T_map_base
  [[nodiscard]] const std::map<PlaneId, Plane>& planes() const { return planes_; }          ///< map frame
  [[nodiscard]] const std::map<RoomId, Room>& rooms() const { return rooms_; }
  [[nodiscard]] const std::map<CorridorId, Corridor>& corridors() const { return corridors_; }
  [[nodiscard]] const std::map<FactorId, Factor>& factors() const { return factors_; }
  /// By the plane that was merged away.
  [[nodiscard]] const std::map<PlaneId, MergeRecord>& merges() const { return merges_; }

  /// Value, or null when there is none.
  [[nodiscard]] const Pose* find(KeyframeId id) const;
  [[nodiscard]] const Plane* find(PlaneId id) const;
  [[nodiscard]] const Room* find(RoomId id) const;
  [[nodiscard]] const Corridor* find(CorridorId id) const;
  [[nodiscard]] const Factor* find(FactorId id) const;
  [[nodiscard]] bool contains(const VariableId& id) const;

  /// Factors of a variable; empty when it has none.
  [[nodiscard]] const std::set<FactorId>& factors_of(const VariableId& id) const;

  /// The plane that now stands for this one: itself, or what it was merged into, followed to the end.
  [[nodiscard]] PlaneId representative(PlaneId id) const;

  /// A fresh id, never given before; the transaction that adds the variable uses it.
  PlaneId new_plane_id() { return {next_plane_++}; }
  RoomId new_room_id() { return {next_room_++}; }
  CorridorId new_corridor_id() { return {next_corridor_++}; }

  /// New value of a variable that is in the graph (new estimate; also a room's or corridor's constants). Throws std::invalid_argument when it isn't,
  /// or the value isn't finite.
  void set(KeyframeId id, const Pose& T_map_base);
  void set(PlaneId id, const Plane& plane);
  void set(RoomId id, const Room& room);
  void set(CorridorId id, const Corridor& corridor);

  /// How often views of planes have been taken away or re-pointed, and keyframes' values set: who keeps sums over views sees by these that they are
  /// out of date.
  [[nodiscard]] std::int64_t views_withdrawn() const { return views_withdrawn_; }
  [[nodiscard]] std::int64_t keyframes_moved() const { return keyframes_moved_; }
  /// How often factors have been taken away, re-pointed or put back: while this stays, all that is new has ids beyond those known.
  [[nodiscard]] std::int64_t factors_edited() const { return factors_edited_; }
  /// Which these were since there had been so many of them: also ids of factors that are no more. Nothing when that is too long ago to be known.
  [[nodiscard]] std::optional<std::set<FactorId>> factors_edited_since(std::int64_t count) const;

  /// Variables, factors and records; not how they came about.
  friend bool operator==(const Graph& a, const Graph& b);

 private:
  friend class GraphEdit;
  friend struct GraphReader;

  void note_edit(FactorId id);

  std::map<KeyframeId, Pose> keyframes_;
  std::map<PlaneId, Plane> planes_;
  std::map<RoomId, Room> rooms_;
  std::map<CorridorId, Corridor> corridors_;
  std::map<FactorId, Factor> factors_;
  std::map<PlaneId, MergeRecord> merges_;
  std::map<VariableId, std::set<FactorId>> factors_of_;  // only variables with factors
  std::int64_t next_plane_ = 0;
  std::int64_t next_room_ = 0;
  std::int64_t next_corridor_ = 0;
  std::int64_t next_factor_ = 0;
  std::int64_t views_withdrawn_ = 0;
  std::int64_t keyframes_moved_ = 0;
  std::int64_t factors_edited_ = 0;
  std::deque<FactorId> edited_;  // the latest of these edits, in order
};

}  // namespace sgraph
