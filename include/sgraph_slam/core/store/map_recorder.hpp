#pragma once

#include <cstdint>
#include <map>
#include <unordered_set>

#include "sgraph_slam/core/store/map_observer.hpp"
#include "sgraph_slam/core/store/map_store.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"

namespace sgraph {

/// Keeps a map file up to date with the back end: finds what has changed since it was last shown the map and hands it to the store.
class MapRecorder : public MapObserver {
 public:
  /// The store must outlive it. The first time that it is shown a map it writes all of it.
  explicit MapRecorder(MapStore& store) : store_(store) {}
  /// `known`: what the file holds already, when the back end has taken the map up from there.
  MapRecorder(MapStore& store, const StoredMap& known);

  void changed(const MapView& view) override;

 private:
  void note_poses(const MapView& view, StoreBatch& batch);
  void note_planes(const MapView& view, StoreBatch& batch);
  void note_sightings(const PlaneRecord& record, StoreBatch& batch);
  void note_factors(const MapView& view, StoreBatch& batch);
  void compare_factors(const std::map<FactorId, Factor>& now, StoreBatch& batch);
  void note_documents(const MapView& view, bool whole, StoreBatch& batch);

  MapStore& store_;
  // What the file holds once all batches are written.
  std::map<KeyframeId, Pose> poses_;
  std::map<PlaneId, StoredPlane> planes_;
  std::map<FactorId, Factor> factors_;
  std::map<PlaneId, MergeRecord> merges_;
  std::map<PlaneId, std::size_t> views_;     ///< written of each plane
  std::unordered_set<std::int64_t> viewed_;  ///< factors of the views written; asked for all of them after each edit
  std::map<PlaneId, KeyframeSet> retired_;   ///< as StoredMap::retired
  std::int64_t factors_edited_ = -1;         ///< as the graph counts
  std::map<std::string, std::string> documents_;
  std::size_t decisions_ = 0;
};

}  // namespace sgraph
