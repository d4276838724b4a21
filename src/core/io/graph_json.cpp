#include "sgraph_slam/core/io/graph_json.hpp"

#include <nlohmann/json.hpp>
#include <stdexcept>

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
  return {{"id", keyframe.id.value},
          {"stamp", keyframe.stamp.seconds()},
          {"nanoseconds", keyframe.stamp.nanoseconds},
          {"pose", to_json(keyframe.T_map_base)},
          {"odom_pose", to_json(keyframe.T_odom_base)},
          {"scans", scans}};
}

Json to_json(const ScenePlane& plane) {
  Json extent = Json::array();
  for (const auto& corner : plane.extent) extent.push_back(numbers(corner));
  return {{"id", plane.id.value},
          {"class", to_string(plane.plane_class)},
          {"normal", numbers(plane.plane.normal)},
          {"d", plane.plane.d},
          {"covariance", numbers(plane.covariance)},
          {"extent", extent},
          {"keyframes", ids(plane.keyframes)}};
}

Json to_json(const SceneRoom& room) {
  return {{"id", room.id.value}, {"center", numbers(room.center)}, {"width", numbers(room.width)}, {"yaw", room.yaw}, {"planes", ids(room.planes)}};
}

Json to_json(const SceneCorridor& corridor) {
  return {{"id", corridor.id.value}, {"center", numbers(corridor.center)}, {"width", Json::array({corridor.width})},
          {"yaw", corridor.yaw},     {"length", corridor.length},          {"planes", ids(corridor.planes)}};
}

Json to_json(const SceneOpening& opening) { return {{"from", opening.from}, {"to", opening.to}, {"position", numbers(opening.position)}}; }

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
  return plane;
}

SceneRoom room_from(const Json& json) {
  return {{integer_from(json.at("id"))},
          vector_from<3>(json.at("center")),
          vector_from<2>(json.at("width")),
          json.at("yaw").get<double>(),
          ids_from<PlaneId>(json.at("planes"))};
}

SceneCorridor corridor_from(const Json& json) {
  return {{integer_from(json.at("id"))}, vector_from<3>(json.at("center")), vector_from<1>(json.at("width"))[0],
          json.at("yaw").get<double>(),  json.at("length").get<double>(),   ids_from<PlaneId>(json.at("planes"))};
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
  snapshot.factors_json = json.at("factors").dump();
  return snapshot;
}

}  // namespace

std::string graph_json(const GraphSnapshot& snapshot) {
  Json openings = Json::array();
  for (const SceneOpening& opening : snapshot.openings) openings.push_back(to_json(opening));
  const Json json = {{"format", format},
                     {"frame", snapshot.frame},
                     {"version", snapshot.version},
                     {"T_map_odom", to_json(snapshot.T_map_odom)},
                     {"dominant_yaw", snapshot.dominant_yaw},
                     {"keyframes", values(snapshot.keyframes)},
                     {"planes", values(snapshot.planes)},
                     {"rooms", values(snapshot.rooms)},
                     {"corridors", values(snapshot.corridors)},
                     {"openings", openings},
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
