#include "sgraph_slam/core/eval/plan.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include <Eigen/Geometry>

namespace sgraph {
namespace {

using nlohmann::json;

Eigen::Vector2d point2(const json& j) { return {j.at(0).get<double>(), j.at(1).get<double>()}; }
Eigen::Vector3d point3(const json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()}; }

std::vector<Eigen::Vector2d> polygon_from(const json& j) {
  std::vector<Eigen::Vector2d> polygon;
  for (const json& corner : j) polygon.push_back(point2(corner));
  return polygon;
}

PlanWall wall_from(const json& j) {
  PlanWall wall;
  wall.p = point2(j.at("p"));
  wall.q = point2(j.at("q"));
  wall.thickness = j.at("t").get<double>();
  wall.bottom = j.value("z", 0.0);
  wall.height = j.value("height", wall.height);
  wall.extend_p = j.value("extend_p", 0.0);
  wall.extend_q = j.value("extend_q", 0.0);
  wall.glass = j.value("glass", false);
  wall.lean = j.value("lean", 0.0);
  wall.bow = j.value("bow", 0.0);
  if (!(wall.length() > 0) || !(wall.thickness >= 0)) throw std::runtime_error("a wall without length, or of negative thickness");
  for (const json& o : j.value("openings", json::array())) {
    wall.openings.push_back(
        {o.at("begin").get<double>(), o.at("end").get<double>(), o.value("bottom", 0.0), o.at("top").get<double>(), o.value("pane", false)});
  }
  std::sort(wall.openings.begin(), wall.openings.end(), [](const PlanOpening& a, const PlanOpening& b) { return a.begin < b.begin; });
  return wall;
}

PlanBlock block_from(const json& j, bool furniture) {
  return {point3(j.at("center")), point3(j.at("size")), j.value("yaw", 0.0), j.value("round", false), furniture};
}

PlanPlace place_from(const json& j) {
  PlanPlace place;
  const json id = j.value("id", j.value("name", json("")));
  place.name = id.is_string() ? id.get<std::string>() : id.dump();
  place.center = point2(j.at("center"));
  place.width = point2(j.at("width"));
  place.z = j.value("z", 0.0);
  if (j.contains("yaw")) {
    place.yaw = j.at("yaw").get<double>();
  } else {
    const Eigen::Vector2d edge = point2(j.at("polygon").at(1)) - point2(j.at("polygon").at(0));
    place.yaw = std::atan2(edge.y(), edge.x());
  }
  return place;
}

PlanPlace not_entered(PlanPlace place) {
  place.entered = false;
  return place;
}

PlanShape shape_from(const json& storey, const char* key) {
  PlanShape shape;
  if (!storey.contains(key)) return shape;
  const json& j = storey.at(key);
  shape.origin = point2(j.at("origin"));
  shape.slope = point2(j.at("slope"));
  for (const json& w : j.at("waves")) shape.waves.push_back({point2(w.at("number")), w.at("phase").get<double>(), w.at("amplitude").get<double>()});
  return shape;
}

PlanLevel level_from(const json& j) {
  PlanLevel level;
  level.floor = j.value("elevation", 0.0);
  level.has_floor = j.value("floor", true);
  level.ceiling_known = true;
  if (j.value("ceiling", true)) level.ceiling = level.floor + j.at("height").get<double>();
  level.outline = polygon_from(j.at("outline"));
  level.floor_shape = shape_from(j, "floor_shape");
  level.ceiling_shape = shape_from(j, "ceiling_shape");
  return level;
}

// Floors under the walls of one height each, half a metre beyond them.
std::vector<PlanLevel> levels_under(const std::vector<PlanWall>& walls) {
  std::map<double, Eigen::AlignedBox2d> boxes;
  for (const PlanWall& w : walls) boxes[w.bottom].extend(w.p).extend(w.q);
  std::vector<PlanLevel> levels;
  for (const auto& [z, box] : boxes) {
    const Eigen::Vector2d a = box.min().array() - 0.5;
    const Eigen::Vector2d b = box.max().array() + 0.5;
    PlanLevel level;
    level.floor = z;
    level.outline = {a, {b.x(), a.y()}, b, {a.x(), b.y()}};
    levels.push_back(level);
  }
  return levels;
}

Plan plan_from(const json& j) {
  Plan plan;
  plan.name = j.value("name", "");
  for (const json& w : j.at("walls")) plan.walls.push_back(wall_from(w));
  for (const json& b : j.value("columns", json::array())) plan.blocks.push_back(block_from(b, false));
  for (const json& b : j.value("stairs", json::array())) plan.blocks.push_back(block_from(b, false));
  for (const json& b : j.value("furniture", json::array())) plan.blocks.push_back(block_from(b, true));
  plan.furniture_known = j.contains("furniture");
  for (const json& r : j.value("rooms", json::array())) plan.rooms.push_back(place_from(r));
  for (const json& c : j.value("corridors", json::array())) plan.corridors.push_back(place_from(c));
  for (const json& r : j.value("other_rooms", json::array())) plan.rooms.push_back(not_entered(place_from(r)));
  for (const json& c : j.value("other_corridors", json::array())) plan.corridors.push_back(not_entered(place_from(c)));
  for (const json& s : j.value("storeys", json::array())) plan.levels.push_back(level_from(s));
  if (j.contains("ground")) plan.ground = j.at("ground").get<double>();
  if (plan.levels.empty()) plan.levels = levels_under(plan.walls);
  return plan;
}

}  // namespace

double PlanShape::operator()(const Eigen::Vector2d& at) const {
  double z = slope.dot(at - origin);
  for (const Wave& wave : waves) z += wave.amplitude * std::sin(wave.number.dot(at) + wave.phase);
  return z;
}

Plan read_plan(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  try {
    return plan_from(json::parse(in));
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

std::vector<PlanBlock> panes(const Plan& plan) {
  std::vector<PlanBlock> blocks;
  for (const PlanWall& wall : plan.walls) {
    const Eigen::Vector2d along = wall.direction();
    for (const PlanOpening& opening : wall.openings) {
      if (!opening.pane) continue;
      const Eigen::Vector2d middle = wall.p + 0.5 * (opening.begin + opening.end) * along;
      PlanBlock pane;
      pane.center = {middle.x(), middle.y(), wall.bottom + 0.5 * (opening.bottom + opening.top)};
      pane.size = {opening.end - opening.begin, 0, opening.top - opening.bottom};
      pane.yaw = std::atan2(along.y(), along.x());
      blocks.push_back(pane);
    }
  }
  return blocks;
}

}  // namespace sgraph
