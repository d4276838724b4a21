#include "sgraph_slam/core/io/map_files.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace sgraph {
namespace {

using nlohmann::json;

Eigen::Vector3d point3(const json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()}; }

std::vector<PlaneId> ids_from(const json& j) {
  std::vector<PlaneId> ids;
  for (const json& id : j) ids.push_back({id.get<std::int64_t>()});
  return ids;
}

PlaneClass class_from(const std::string& word) {
  for (const PlaneClass c : {PlaneClass::x, PlaneClass::y, PlaneClass::horizontal}) {
    if (word == to_string(c)) return c;
  }
  return PlaneClass::unclassified;
}

ScenePlane plane_from(const json& j) {
  ScenePlane plane;
  plane.id = {j.at("id").get<std::int64_t>()};
  plane.plane = {point3(j.at("normal")), j.at("d").get<double>()};
  plane.plane_class = class_from(j.at("class").get<std::string>());
  for (const json& corner : j.at("extent")) plane.extent.push_back(point3(corner));
  for (const json& id : j.value("keyframes", json::array())) plane.keyframes.insert({id.get<std::int64_t>()});
  return plane;
}

SceneRoom room_from(const json& j) {
  SceneRoom room;
  room.id = {j.at("id").get<std::int64_t>()};
  room.center = point3(j.at("center"));
  room.width = {j.at("width").at(0).get<double>(), j.at("width").at(1).get<double>()};
  room.yaw = j.at("yaw").get<double>();
  room.planes = ids_from(j.at("planes"));
  return room;
}

SceneCorridor corridor_from(const json& j) {
  SceneCorridor corridor;
  corridor.id = {j.at("id").get<std::int64_t>()};
  corridor.center = point3(j.at("center"));
  corridor.width = j.at("width").is_array() ? j.at("width").at(0).get<double>() : j.at("width").get<double>();
  corridor.yaw = j.at("yaw").get<double>();
  corridor.length = j.at("length").get<double>();
  corridor.planes = ids_from(j.at("planes"));
  return corridor;
}

}  // namespace

Structure read_structure(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  try {
    const json graph = json::parse(in);
    Structure structure;
    for (const json& p : graph.at("planes")) structure.planes.push_back(plane_from(p));
    for (const json& r : graph.at("rooms")) structure.rooms.push_back(room_from(r));
    for (const json& c : graph.at("corridors")) structure.corridors.push_back(corridor_from(c));
    return structure;
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace sgraph
