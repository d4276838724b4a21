#include "sgraph_slam/core/graph/serialization.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "json_values.hpp"
#include "sgraph_slam/core/graph/value_checks.hpp"
#include "sgraph_slam/core/util/json_integer.hpp"

namespace sgraph {
namespace {

using Json = nlohmann::json;

constexpr int format = 1;

Json factors_json(const std::map<FactorId, Factor>& factors) {
  Json out = Json::array();
  for (const auto& [id, factor] : factors) out.push_back(factor_json(id, factor));
  return out;
}

Json merge_json(PlaneId merged, const MergeRecord& record) {
  Json repointed = Json::array();
  for (const FactorId factor : record.repointed) repointed.push_back(factor.value);
  return {{"merged", merged.value},
          {"kept", record.kept.value},
          {"plane", plane_json(record.plane)},
          {"repointed", repointed},
          {"dropped", factors_json(record.dropped)}};
}

Json merges_json(const std::map<PlaneId, MergeRecord>& merges) {
  Json out = Json::array();
  for (const auto& [id, record] : merges) out.push_back(merge_json(id, record));
  return out;
}

}  // namespace

Json pose_json(const Pose& pose) {
  const Eigen::Vector4d q = pose.rotation.coeffs();
  return {pose.translation[0], pose.translation[1], pose.translation[2], q[0], q[1], q[2], q[3]};
}

Pose pose_from(const Json& json) {
  const auto v = vector_from<7>(json);
  Pose pose;
  pose.translation = v.head<3>();
  pose.rotation.coeffs() = v.tail<4>();
  return pose;
}

Json plane_json(const Plane& plane) { return {plane.normal[0], plane.normal[1], plane.normal[2], plane.d}; }

Plane plane_from(const Json& json) {
  const auto v = vector_from<4>(json);
  return {v.head<3>(), v[3]};
}

/// Fills a graph from JSON and checks that it hangs together.
struct GraphReader {
  Graph graph;

  template <class Key, class Value>
  static void add(std::map<Key, Value>& to, const Json& json, const Value& value, const char* what) {
    const Key id{integer_from(json.at("id"))};
    if (!id.valid() || !valid(value)) throw std::runtime_error(std::string("invalid ") + what + " " + std::to_string(id.value));
    if (!to.emplace(id, value).second) throw std::runtime_error(std::string(what) + " " + std::to_string(id.value) + " is given twice");
  }

  void read_variables(const Json& json) {
    for (const Json& k : json.at("keyframes")) add(graph.keyframes_, k, pose_from(k.at("pose")), "keyframe");
    for (const Json& p : json.at("planes")) add(graph.planes_, p, Plane{vector_from<3>(p.at("normal")), p.at("d").get<double>()}, "plane");
    for (const Json& r : json.at("rooms")) {
      const Room room{r.at("yaw").get<double>(), r.at("z").get<double>(), vector_from<2>(r.at("position")), vector_from<2>(r.at("width"))};
      add(graph.rooms_, r, room, "room");
    }
    for (const Json& c : json.at("corridors")) {
      const Corridor corridor{c.at("yaw").get<double>(), c.at("along").get<double>(), c.at("z").get<double>(), c.at("position").get<double>(),
                              c.at("width").get<double>()};
      add(graph.corridors_, c, corridor, "corridor");
    }
  }

  static std::map<FactorId, Factor> factors_from(const Json& json) {
    std::map<FactorId, Factor> out;
    for (const Json& f : json) {
      const FactorId id{integer_from(f.at("id"))};
      const Factor factor = factor_from(f);
      if (!id.valid() || !valid(factor)) throw std::runtime_error("invalid factor " + std::to_string(id.value));
      if (!out.emplace(id, factor).second) throw std::runtime_error("factor " + std::to_string(id.value) + " is given twice");
    }
    return out;
  }

  void read_factors(const Json& json) {
    graph.factors_ = factors_from(json);
    index_factors();
  }

  void index_factors() {
    for (const auto& [id, factor] : graph.factors_) {
      for (const VariableId& variable : blocks(factor.data)) {
        if (!graph.contains(variable))
          throw std::runtime_error("factor " + std::to_string(id.value) + " names " + to_string(variable) + ", which isn't there");
        if (!graph.factors_of_[variable].insert(id).second)
          throw std::runtime_error("factor " + std::to_string(id.value) + " names " + to_string(variable) + " twice");
      }
    }
  }

  static std::pair<PlaneId, MergeRecord> merge_from(const Json& m) {
    MergeRecord record;
    record.kept = {integer_from(m.at("kept"))};
    record.plane = plane_from(m.at("plane"));
    for (const Json& id : m.at("repointed")) record.repointed.insert({integer_from(id)});
    record.dropped = factors_from(m.at("dropped"));
    return {{integer_from(m.at("merged"))}, std::move(record)};
  }

  void read_merges(const Json& json) {
    for (const Json& m : json) graph.merges_.insert(merge_from(m));
    check_merges();
  }

  void check_merges() const {
    for (const auto& [merged, record] : graph.merges_) {
      if (!valid(record.plane) || graph.planes_.count(merged) > 0) throw std::runtime_error("invalid merge of plane " + std::to_string(merged.value));
      PlaneId end = merged;
      for (std::size_t steps = 0; graph.merges_.count(end) > 0 && steps <= graph.merges_.size(); ++steps) end = graph.merges_.at(end).kept;
      if (!graph.contains(end)) throw std::runtime_error("plane " + std::to_string(merged.value) + " was merged into one that isn't there");
    }
  }

  template <class Key, class Value>
  static std::int64_t beyond(const std::map<Key, Value>& map) {
    if (map.empty()) return 0;
    const std::int64_t last = map.rbegin()->first.value;
    if (last == std::numeric_limits<std::int64_t>::max()) throw std::runtime_error("no id is left after " + std::to_string(last));
    return last + 1;
  }

  void read_counters(const Json& json) {
    const auto counter = [&json](const char* name) { return json.contains(name) ? integer_from(json.at(name)) : std::int64_t{0}; };
    set_counters({counter("plane"), counter("room"), counter("corridor"), counter("factor")});
  }

  void set_counters(const std::array<std::int64_t, 4>& next) {
    graph.next_plane_ = std::max({next[0], beyond(graph.planes_), beyond(graph.merges_)});
    graph.next_room_ = std::max(next[1], beyond(graph.rooms_));
    graph.next_corridor_ = std::max(next[2], beyond(graph.corridors_));
    graph.next_factor_ = std::max(next[3], beyond(graph.factors_));
  }

  static std::array<std::int64_t, 4> next_ids(const Graph& graph) {
    return {graph.next_plane_, graph.next_room_, graph.next_corridor_, graph.next_factor_};
  }

  static Json counters(const Graph& graph) {
    return {{"plane", graph.next_plane_}, {"room", graph.next_room_}, {"corridor", graph.next_corridor_}, {"factor", graph.next_factor_}};
  }

  template <class Key, class Value>
  static void check_values(const std::map<Key, Value>& values, const char* what) {
    for (const auto& [id, value] : values) {
      if (!id.valid() || !valid(value)) throw std::runtime_error(std::string("invalid ") + what + " " + std::to_string(id.value));
    }
  }

  void take(GraphParts& parts) {
    check_values(parts.keyframes, "keyframe");
    check_values(parts.planes, "plane");
    check_values(parts.rooms, "room");
    check_values(parts.corridors, "corridor");
    check_values(parts.factors, "factor");
    graph.keyframes_ = std::move(parts.keyframes);
    graph.planes_ = std::move(parts.planes);
    graph.rooms_ = std::move(parts.rooms);
    graph.corridors_ = std::move(parts.corridors);
    graph.factors_ = std::move(parts.factors);
    graph.merges_ = std::move(parts.merges);
    index_factors();
    check_merges();
    set_counters(parts.next);
  }
};

std::string factors_to_json(const Graph& graph) { return factors_json(graph.factors()).dump(); }

std::map<FactorId, Factor> factors_from_json(const std::string& text) {
  try {
    return GraphReader::factors_from(Json::parse(text));
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("graph: ") + error.what());
  }
}

std::string to_json(const Graph& graph) {
  Json json{{"format", format}};
  json["keyframes"] = json["planes"] = json["rooms"] = json["corridors"] = Json::array();
  for (const auto& [id, pose] : graph.keyframes()) json["keyframes"].push_back({{"id", id.value}, {"pose", pose_json(pose)}});
  for (const auto& [id, plane] : graph.planes()) {
    json["planes"].push_back({{"id", id.value}, {"normal", vector_json<3>(plane.normal)}, {"d", plane.d}});
  }
  for (const auto& [id, room] : graph.rooms()) {
    json["rooms"].push_back(
        {{"id", id.value}, {"yaw", room.yaw}, {"z", room.z}, {"position", vector_json<2>(room.position)}, {"width", vector_json<2>(room.width)}});
  }
  for (const auto& [id, c] : graph.corridors()) {
    json["corridors"].push_back({{"id", id.value}, {"yaw", c.yaw}, {"along", c.along}, {"z", c.z}, {"position", c.position}, {"width", c.width}});
  }
  json["factors"] = factors_json(graph.factors());
  json["merges"] = merges_json(graph.merges());
  json["next"] = GraphReader::counters(graph);
  return json.dump();
}

Graph graph_from_json(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    if (integer_from(json.at("format")) != format) throw std::runtime_error("format " + json.at("format").dump() + " isn't known");
    GraphReader reader;
    reader.read_variables(json);
    reader.read_factors(json.at("factors"));
    reader.read_merges(json.value("merges", Json::array()));
    reader.read_counters(json.value("next", Json::object()));
    return std::move(reader.graph);
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("graph: ") + error.what());
  }
}

std::string factor_to_json(FactorId id, const Factor& factor) { return factor_json(id, factor).dump(); }

std::string merge_to_json(PlaneId merged, const MergeRecord& record) { return merge_json(merged, record).dump(); }

std::pair<FactorId, Factor> factor_from_json(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    return {{integer_from(json.at("id"))}, factor_from(json)};
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("graph: ") + error.what());
  }
}

std::pair<PlaneId, MergeRecord> merge_from_json(const std::string& text) {
  try {
    return GraphReader::merge_from(Json::parse(text));
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("graph: ") + error.what());
  }
}

std::array<std::int64_t, 4> next_ids(const Graph& graph) { return GraphReader::next_ids(graph); }

Graph graph_from_parts(GraphParts parts) {
  try {
    GraphReader reader;
    reader.take(parts);
    return std::move(reader.graph);
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("graph: ") + error.what());
  }
}

}  // namespace sgraph
