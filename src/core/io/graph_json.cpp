#include "sgraph_slam/core/io/graph_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "sgraph_slam/core/math/signed_area.hpp"
#include "sgraph_slam/core/util/json_integer.hpp"

namespace sgraph {
namespace {

using Json = nlohmann::ordered_json;

constexpr int format = 1;

template <class Vector>
Json numbers(const Vector& v) {
  Json json = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) json.push_back(v.data()[i]);
  return json;
}

Json to_json(const Pose& pose) {
  const auto& q = pose.rotation;
  const auto& t = pose.translation;
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

template <class Ids>
Json ids(const Ids& values) {
  Json json = Json::array();
  for (const auto id : values) json.push_back(id.value);
  return json;
}

Json to_json(const SceneKeyframe& keyframe) {
  Json scans = Json::array();
  for (const StampedPose& scan : *keyframe.scans) scans.push_back({{"nanoseconds", scan.stamp.nanoseconds}, {"pose", to_json(scan.pose)}});
  Json json = {{"id", keyframe.id.value},
               {"stamp", keyframe.stamp.seconds()},
               {"nanoseconds", keyframe.stamp.nanoseconds},
               {"pose", to_json(keyframe.T_map_base)},
               {"odom_pose", to_json(keyframe.T_odom_base)},
               {"scans", scans}};
  if (keyframe.storey != 0) json["storey"] = keyframe.storey;
  return json;
}

Json to_json(const ScenePlane& plane) {
  Json extent = Json::array();
  for (const auto& corner : plane.extent) extent.push_back(numbers(corner));
  Json json = {{"id", plane.id.value},
               {"class", to_string(plane.plane_class)},
               {"normal", numbers(plane.plane.normal)},
               {"d", plane.plane.d},
               {"covariance", numbers(plane.covariance)},
               {"extent", extent},
               {"keyframes", ids(plane.keyframes)}};
  if (plane.storey != 0) json["storey"] = plane.storey;
  return json;
}

Json to_json(const SceneSide& side) {
  switch (side.kind) {
    case SceneSide::Kind::wall: return {{"plane", side.plane.value}};
    case SceneSide::Kind::door: return {{"door", side.door.value}};
    case SceneSide::Kind::opening: return {{"opening", true}};
    case SceneSide::Kind::unknown: break;
  }
  return {{"unknown", true}};
}

const std::vector<std::vector<Eigen::Vector2d>>& holes_of(const SceneRoom& room) { return room.holes; }
const std::vector<std::vector<Eigen::Vector2d>>& holes_of(const SceneBranching& branching) { return branching.holes; }
const std::vector<std::vector<Eigen::Vector2d>>& holes_of(const SceneCorridor&) {
  static const std::vector<std::vector<Eigen::Vector2d>> none;
  return none;
}

template <class Place>
void add_outline(const Place& place, const char* kind, Json& json) {
  json["kind"] = kind;
  json["area"] = signed_area(place.polygon, holes_of(place));
  json["complete"] = is_complete(place.edges);
  json["polygon"] = Json::array();
  for (const Eigen::Vector2d& corner : place.polygon) json["polygon"].push_back(numbers(corner));
  if (!holes_of(place).empty()) json["holes"] = Json::array();
  for (const auto& hole : holes_of(place)) {
    Json corners = Json::array();
    for (const Eigen::Vector2d& corner : hole) corners.push_back(numbers(corner));
    json["holes"].push_back(corners);
  }
  json["edges"] = Json::array();
  for (const SceneSide& side : place.edges) json["edges"].push_back(to_json(side));
  json["storey"] = place.storey;
}

Json to_json(const SceneRoom& room) {
  const Json width = room.is_rectangle() ? numbers(room.width) : Json::array();
  Json json = {{"id", room.id.value}, {"center", numbers(room.center)}, {"width", width}, {"yaw", room.yaw}, {"planes", ids(room.planes)}};
  add_outline(room, room.is_rectangle() ? "room" : "hall", json);
  return json;
}

Json to_json(const SceneCorridor& corridor) {
  Json json = {{"id", corridor.id.value}, {"center", numbers(corridor.center)}, {"width", Json::array({corridor.width})},
               {"yaw", corridor.yaw},     {"length", corridor.length},          {"planes", ids(corridor.planes)}};
  add_outline(corridor, "corridor", json);
  return json;
}

Json to_json(const SceneDoor& door) {
  return {{"id", door.id.value}, {"from", door.from},   {"to", door.to},         {"position", numbers(door.position)},
          {"yaw", door.yaw},     {"width", door.width}, {"height", door.height}, {"storey", door.storey}};
}

Json to_json(const SceneStorey& storey) {
  return {
      {"id", storey.id}, {"z", storey.z}, {"ceiling", storey.ceiling}, {"height_known", storey.height_known}, {"height_sigma", storey.height_sigma}};
}

Json to_json(const SceneOpening& opening) { return {{"from", opening.from}, {"to", opening.to}, {"position", numbers(opening.position)}}; }

// All pieces of floor, each once: rooms, corridors, and corridors that are one piece together under the name of the first.
Json places_of(const GraphSnapshot& snapshot) {
  Json places = Json::array();
  const auto add = [&](const std::string& name, Json json) {
    json["id"] = name;
    places.push_back(std::move(json));
  };
  for (const auto& [id, room] : snapshot.rooms) add("room/" + std::to_string(id.value), to_json(room));
  std::set<CorridorId> of_branchings;
  for (const SceneBranching& branching : snapshot.branchings) of_branchings.insert(branching.parts.begin(), branching.parts.end());
  for (const auto& [id, corridor] : snapshot.corridors) {
    if (of_branchings.count(id) == 0) add("corridor/" + std::to_string(id.value), to_json(corridor));
  }
  for (const SceneBranching& branching : snapshot.branchings) {
    if (branching.parts.empty()) continue;
    const auto name = [](CorridorId id) { return "corridor/" + std::to_string(id.value); };
    Json json = {{"id", name(branching.parts.front())}, {"parts", Json::array()}};
    for (const CorridorId part : branching.parts) json["parts"].push_back(name(part));
    const auto first = snapshot.corridors.find(branching.parts.front());
    if (first != snapshot.corridors.end()) json["center"] = numbers(first->second.center);
    add_outline(branching, "corridor", json);
    places.push_back(std::move(json));
  }
  return places;
}

template <class Map>
Json values(const Map& map) {
  Json json = Json::array();
  for (const auto& [id, value] : map) json.push_back(to_json(value));
  return json;
}

// What follows reads; `at` throws with the name of what is missing.

template <int Size>
Eigen::Matrix<double, Size, 1> vector_from(const Json& json) {
  if (json.size() != Size) throw std::runtime_error("expected " + std::to_string(Size) + " numbers, found " + std::to_string(json.size()));
  Eigen::Matrix<double, Size, 1> v;
  for (int i = 0; i < Size; ++i) v[i] = json[static_cast<std::size_t>(i)].get<double>();
  return v;
}

Pose pose_from(const Json& json) {
  const auto v = vector_from<7>(json);
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  if (!v.allFinite() || std::abs(rotation.norm() - 1) > 1e-6)
    throw std::runtime_error("a pose that is not finite or whose quaternion is not of length 1");
  return {rotation, v.head<3>()};
}

template <class IdType>
std::vector<IdType> ids_from(const Json& json) {
  std::vector<IdType> ids;
  for (const Json& id : json) ids.push_back({integer_from(id)});
  return ids;
}

PlaneClass class_from(const std::string& word) {
  for (const PlaneClass value : {PlaneClass::x, PlaneClass::y, PlaneClass::horizontal, PlaneClass::unclassified}) {
    if (word == to_string(value)) return value;
  }
  throw std::runtime_error("unknown class of a plane: " + word);
}

SceneKeyframe keyframe_from(const Json& json) {
  SceneKeyframe keyframe;
  keyframe.id = {integer_from(json.at("id"))};
  keyframe.stamp = {integer_from(json.at("nanoseconds"))};
  keyframe.T_map_base = pose_from(json.at("pose"));
  keyframe.T_odom_base = pose_from(json.at("odom_pose"));
  Trajectory scans;
  for (const Json& scan : json.at("scans")) scans.push_back({{integer_from(scan.at("nanoseconds"))}, pose_from(scan.at("pose"))});
  keyframe.scans = std::move(scans);
  if (json.contains("storey")) keyframe.storey = static_cast<int>(integer_from(json.at("storey")));
  return keyframe;
}

ScenePlane plane_from(const Json& json) {
  ScenePlane plane;
  plane.id = {integer_from(json.at("id"))};
  plane.plane_class = class_from(json.at("class").get<std::string>());
  plane.plane = {vector_from<3>(json.at("normal")), json.at("d").get<double>()};
  plane.covariance = Eigen::Map<const Eigen::Matrix3d>(vector_from<9>(json.at("covariance")).eval().data());
  for (const Json& corner : json.at("extent")) plane.extent.push_back(vector_from<3>(corner));
  for (const KeyframeId id : ids_from<KeyframeId>(json.at("keyframes"))) plane.keyframes.insert(id);
  if (json.contains("storey")) plane.storey = static_cast<int>(integer_from(json.at("storey")));
  return plane;
}

SceneSide side_from(const Json& json) {
  if (json.contains("plane")) return {SceneSide::Kind::wall, {integer_from(json.at("plane"))}, {}};
  if (json.contains("door")) return {SceneSide::Kind::door, {}, {integer_from(json.at("door"))}};
  return {json.contains("opening") ? SceneSide::Kind::opening : SceneSide::Kind::unknown, {}, {}};
}

// Graphs written before places had outlines have none.
template <class Place>
void read_outline(const Json& json, Place& place, std::vector<std::vector<Eigen::Vector2d>>& holes) {
  if (!json.contains("polygon")) return;
  for (const Json& corner : json.at("polygon")) place.polygon.push_back(vector_from<2>(corner));
  for (const Json& side : json.at("edges")) place.edges.push_back(side_from(side));
  for (const Json& hole : json.value("holes", Json::array())) {
    auto& corners = holes.emplace_back();
    for (const Json& corner : hole) corners.push_back(vector_from<2>(corner));
  }
  if (place.edges.size() != place.polygon.size()) throw std::runtime_error("a place with another number of edges than corners");
  place.storey = static_cast<int>(integer_from(json.at("storey")));
}

SceneRoom room_from(const Json& json) {
  SceneRoom room;
  room.id = {integer_from(json.at("id"))};
  room.center = vector_from<3>(json.at("center"));
  if (!json.at("width").empty()) room.width = vector_from<2>(json.at("width"));
  room.yaw = json.at("yaw").get<double>();
  room.planes = ids_from<PlaneId>(json.at("planes"));
  read_outline(json, room, room.holes);
  return room;
}

SceneCorridor corridor_from(const Json& json) {
  SceneCorridor corridor;
  corridor.id = {integer_from(json.at("id"))};
  corridor.center = vector_from<3>(json.at("center"));
  corridor.width = vector_from<1>(json.at("width"))[0];
  corridor.yaw = json.at("yaw").get<double>();
  corridor.length = json.at("length").get<double>();
  corridor.planes = ids_from<PlaneId>(json.at("planes"));
  std::vector<std::vector<Eigen::Vector2d>> none;
  read_outline(json, corridor, none);
  return corridor;
}

CorridorId corridor_named(const std::string& name) {
  const std::string prefix = "corridor/";
  if (name.compare(0, prefix.size(), prefix) != 0) throw std::runtime_error("a part of a place that is no corridor: " + name);
  return {integer_from(Json::parse(name.substr(prefix.size())))};
}

// Of "places" those that are not among rooms and corridors.
void read_branchings(const Json& places, std::vector<SceneBranching>& branchings) {
  for (const Json& place : places) {
    if (!place.contains("parts")) continue;
    SceneBranching& branching = branchings.emplace_back();
    for (const Json& part : place.at("parts")) branching.parts.push_back(corridor_named(part.get<std::string>()));
    read_outline(place, branching, branching.holes);
  }
}

SceneDoor door_from(const Json& json) {
  SceneDoor door;
  door.id = {integer_from(json.at("id"))};
  door.from = json.at("from").get<std::string>();
  door.to = json.at("to").get<std::string>();
  door.position = vector_from<3>(json.at("position"));
  door.yaw = json.at("yaw").get<double>();
  door.width = json.at("width").get<double>();
  door.height = json.at("height").get<double>();
  door.storey = json.contains("storey") ? static_cast<int>(integer_from(json.at("storey"))) : 0;
  return door;
}

SceneStorey storey_from(const Json& json) {
  return {static_cast<int>(integer_from(json.at("id"))), json.at("z").get<double>(), json.at("ceiling").get<double>(),
          json.at("height_known").get<bool>(), json.value("height_sigma", 0.0)};
}

GraphSnapshot snapshot_from(const Json& json) {
  if (integer_from(json.at("format")) != format)
    throw std::runtime_error("format " + json.at("format").dump() + "; this program reads " + std::to_string(format));
  GraphSnapshot snapshot;
  snapshot.version = integer_from(json.at("version"));
  snapshot.frame = json.at("frame").get<std::string>();
  snapshot.T_map_odom = pose_from(json.at("T_map_odom"));
  snapshot.dominant_yaw = json.at("dominant_yaw").get<double>();
  const auto insert = [](auto& map, auto value) {
    const auto id = value.id;
    if (!map.emplace(id, std::move(value)).second) throw std::runtime_error("the id " + std::to_string(id.value) + " twice");
  };
  for (const Json& one : json.at("keyframes")) insert(snapshot.keyframes, keyframe_from(one));
  for (const Json& one : json.at("planes")) insert(snapshot.planes, plane_from(one));
  for (const Json& one : json.at("rooms")) insert(snapshot.rooms, room_from(one));
  for (const Json& one : json.at("corridors")) insert(snapshot.corridors, corridor_from(one));
  for (const Json& one : json.at("openings")) {
    snapshot.openings.push_back({one.at("from").get<std::string>(), one.at("to").get<std::string>(), vector_from<3>(one.at("position"))});
  }
  read_branchings(json.value("places", Json::array()), snapshot.branchings);
  for (const Json& one : json.value("doors", Json::array())) insert(snapshot.doors, door_from(one));
  for (const Json& one : json.value("storeys", Json::array())) snapshot.storeys.push_back(storey_from(one));
  snapshot.factors_json = json.at("factors").dump();
  return snapshot;
}

}  // namespace

std::string graph_json(const GraphSnapshot& snapshot) {
  Json openings = Json::array();
  for (const SceneOpening& opening : snapshot.openings) openings.push_back(to_json(opening));
  Json storeys = Json::array();
  for (const SceneStorey& storey : snapshot.storeys) storeys.push_back(to_json(storey));
  const Json json = {{"format", format},
                     {"frame", snapshot.frame},
                     {"version", snapshot.version},
                     {"T_map_odom", to_json(snapshot.T_map_odom)},
                     {"dominant_yaw", snapshot.dominant_yaw},
                     {"keyframes", values(snapshot.keyframes)},
                     {"planes", values(snapshot.planes)},
                     {"rooms", values(snapshot.rooms)},
                     {"corridors", values(snapshot.corridors)},
                     {"places", places_of(snapshot)},
                     {"openings", openings},
                     {"doors", values(snapshot.doors)},
                     {"storeys", storeys},
                     {"factors", Json::parse(snapshot.factors_json)}};
  return json.dump(1) + '\n';
}

GraphSnapshot parse_graph_json(const std::string& text) {
  try {
    return snapshot_from(Json::parse(text));
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(std::string("graph.json: ") + error.what());
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("graph.json: ") + error.what());
  }
}

}  // namespace sgraph
