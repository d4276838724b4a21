#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "sgraph_slam/core/store/map_store.hpp"
#include "sgraph_slam/core/types/keyframe_set.hpp"

namespace sgraph {

/// The contents of a map file.
struct StoredMap {
  std::string path;  ///< of the file; empty when it was made otherwise
  std::map<std::int64_t, StoredSession> sessions;
  std::map<KeyframeId, Keyframe> keyframes;  ///< measurements; without clouds unless they were asked for
  std::map<KeyframeId, std::int64_t> session_of;
  std::map<KeyframeId, Pose> poses;  ///< estimates, map frame
  std::map<PlaneId, StoredPlane> planes;
  std::map<FactorId, StoredView> views;
  std::map<PlaneId, KeyframeSet> retired;  ///< by plane, also one that was merged away: keyframes that saw it and keep no view of it
  std::map<FactorId, Factor> factors;
  std::map<PlaneId, MergeRecord> merges;
  std::array<std::int64_t, 4> next_ids{};  ///< as GraphParts::next
  DecisionLog decisions;
  std::map<KeyframeId, int> keyframe_storeys;  ///< where it isn't the first
  std::map<PlaneId, int> plane_storeys;        ///< likewise
  std::string scene;                           ///< text of graph.json without what the other members hold
  std::vector<std::string> faults;             ///< what could not be read: a damaged cloud
};

enum class Clouds { none, all };

/// Reads a map file, without changing it. Throws StoreError with one line: no such file, no map file, of a newer version, damaged.
StoredMap read_map(const std::string& path, Clouds clouds);

/// The map as the readers of the back end see it, factors and decisions included.
GraphSnapshot snapshot_of(const StoredMap& map);

/// Number of keyframes, size and so on, without reading all of it.
struct MapSummary {
  int schema = 0;
  std::int64_t bytes = 0;
  std::int64_t keyframes = 0;
  std::int64_t planes = 0;
  std::int64_t rooms = 0;
  std::int64_t corridors = 0;
  std::int64_t factors = 0;
  std::int64_t merges = 0;
  std::int64_t points = 0;
  std::int64_t cloud_bytes = 0;
  struct Session {
    StoredSession session;
    std::int64_t keyframes = 0;
    Stamp ended;
    double path = 0;  ///< travelled, by the estimates [m]
  };
  std::vector<Session> sessions;
};
MapSummary summarize_map(const std::string& path);

/// All that is wrong with a map file, a line each; empty when it is whole. Throws StoreError when it cannot be read at all.
std::vector<std::string> check_map(const std::string& path);

}  // namespace sgraph
