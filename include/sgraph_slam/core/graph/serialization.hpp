#pragma once

#include <map>
#include <string>

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

}  // namespace sgraph
