#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// The whole graph as JSON text, exact: `graph_from_json(to_json(g)) == g`.
/// {"format": 1, "keyframes": [{"id", "pose": [x y z qx qy qz qw]}], "planes": [{"id", "normal", "d"}], "rooms": [...], "corridors": [...],
///  "factors": [...], "merges": [...], "next": {...}}
std::string to_json(const Graph& graph);

/// The factors alone, a JSON array: what GraphSnapshot::factors_json and graph.json hold. Each has "id", "type", "loss" and the fields of its struct.
std::string factors_to_json(const Graph& graph);

/// Back from that array. Throws as below.
std::map<FactorId, Factor> factors_from_json(const std::string& text);

/// Throws std::runtime_error with the place and the reason when the text isn't a valid graph.
Graph graph_from_json(const std::string& text);

/// One factor, one merge as JSON objects, as they stand in the texts above.
std::string factor_to_json(FactorId id, const Factor& factor);
std::string merge_to_json(PlaneId merged, const MergeRecord& record);
/// Back from these texts. Throw std::runtime_error.
std::pair<FactorId, Factor> factor_from_json(const std::string& text);
std::pair<PlaneId, MergeRecord> merge_from_json(const std::string& text);

/// The contents of a graph, for storing it piece by piece.
struct GraphParts {
  std::map<KeyframeId, Pose> keyframes;
  std::map<PlaneId, Plane> planes;
  std::map<RoomId, Room> rooms;
  std::map<CorridorId, Corridor> corridors;
  std::map<FactorId, Factor> factors;
  std::map<PlaneId, MergeRecord> merges;
  std::array<std::int64_t, 4> next{};  ///< least free ids: plane, room, corridor, factor
};

/// The ids that the graph would give next, in the order of GraphParts::next.
std::array<std::int64_t, 4> next_ids(const Graph& graph);

/// A graph of these parts. Throws std::runtime_error when they do not hang together.
Graph graph_from_parts(GraphParts parts);

}  // namespace sgraph
