#include <cmath>
#include <nlohmann/json.hpp>

#include "plan.hpp"
#include "sgraph_slam/core/sim/scene.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph::sim {

namespace {

using nlohmann::json;

json point(const Eigen::Vector2d& p) { return {p.x(), p.y()}; }

json place_json(const Place& place) {
  json polygon = json::array();
  const Eigen::Rotation2Dd turn(place.yaw);
  for (const auto& [x, y] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
    polygon.push_back(point(place.center + turn * Eigen::Vector2d(x * place.width.x(), y * place.width.y())));
  }
  return {{"id", place.name}, {"center", point(place.center)}, {"width", point(place.width)}, {"yaw", place.yaw}, {"polygon", polygon},
          {"z", place.z},     {"height", place.height}};
}

// Whether the robot comes into the place.
bool visited(const Place& place, const std::vector<Eigen::Vector2d>& way) {
  for (const Eigen::Vector2d& p : way) {
    const Eigen::Vector2d inside = Eigen::Rotation2Dd(-place.yaw) * (p - place.center);
    if (std::abs(inside.x()) < 0.5 * place.width.x() && std::abs(inside.y()) < 0.5 * place.width.y()) return true;
  }
  return false;
}

json wall_json(const Wall& wall) {
  json openings = json::array();
  for (const Opening& o : wall.openings) {
    openings.push_back({{"begin", o.begin}, {"end", o.end}, {"bottom", o.bottom}, {"top", o.top}, {"pane", o.pane}});
  }
  return {{"p", point(wall.p)},        {"q", point(wall.q)},  {"z", wall.bottom},
          {"height", wall.height},     {"t", wall.thickness}, {"extend_p", wall.extend_p},
          {"extend_q", wall.extend_q}, {"glass", wall.glass}, {"openings", openings},
          {"lean", wall.lean},         {"bow", wall.bow}};
}

json block_json(const Block& block) {
  json outline = json::array();
  for (const Eigen::Vector2d& p : footprint(block)) outline.push_back(point(p));
  return {{"kind", block.name},
          {"center", {block.center.x(), block.center.y(), block.center.z()}},
          {"size", {block.size.x(), block.size.y(), block.size.z()}},
          {"yaw", block.yaw},
          {"round", block.round},
          {"outline", outline}};
}

json shape_json(const Unevenness& shape) {
  json waves = json::array();
  for (const Unevenness::Wave& w : shape.waves) waves.push_back({{"number", point(w.number)}, {"phase", w.phase}, {"amplitude", w.amplitude}});
  return {{"origin", point(shape.origin)}, {"slope", point(shape.slope)}, {"waves", waves}};
}

json sensor_json(const LidarSettings& lidar) {
  const SensorUnit& unit = lidar.unit;
  json sensor = {{"kind", unit.kind == SensorKind::real ? "real" : "ideal"}};
  if (unit.kind == SensorKind::ideal) {
    sensor["range_noise_m"] = lidar.range_noise;
    return sensor;
  }
  json elevations = json::array();
  for (const double e : unit.elevation_offset) elevations.push_back(e * 180 / M_PI);
  sensor["unit"] = unit.unit;
  sensor["range_offset_m"] = unit.range_offset;
  sensor["elevation_offset_deg"] = elevations;
  sensor["laser_height_m"] = unit.origin_height;
  sensor["laser_height_in_cloud"] = false;
  sensor["sine"] = {{"cycles_per_firing", sine_frequency}, {"amplitude_m", unit.sine_amplitude}, {"phase_rad", unit.sine_phase}};
  return sensor;
}

json surface_json(const Surface& surface) {
  json outline = json::array();
  for (const Eigen::Vector3d& p : surface.outline) outline.push_back({p.x(), p.y(), p.z()});
  return {{"kind", to_string(surface.kind)}, {"outline", outline}};
}

}  // namespace

std::string truth_json(const SimulatedSource& source) {
  return truth_json(source.world(), source.motion(), source.duration(), source.lidar().settings());
}

std::string truth_json(const World& world, const Motion& motion, double duration, const LidarSettings& lidar) {
  json truth = {{"name", world.name},
                {"rotation", 0.0},
                {"rooms", json::array()},
                {"other_rooms", json::array()},
                {"other_corridors", json::array()},
                {"corridors", json::array()},
                {"walls", json::array()},
                {"columns", json::array()},
                {"furniture", json::array()},
                {"storeys", json::array()},
                {"surfaces", json::array()}};
  std::vector<Eigen::Vector2d> way;
  for (double t = 0; t <= duration; t += 0.1) way.emplace_back(motion.pose_at(t).translation.head<2>());
  for (const Storey& storey : world.storeys) {
    for (const Place& place : storey.rooms) truth[visited(place, way) ? "rooms" : "other_rooms"].push_back(place_json(place));
    for (const Place& place : storey.corridors) truth[visited(place, way) ? "corridors" : "other_corridors"].push_back(place_json(place));
    for (const Wall& wall : storey.walls) truth["walls"].push_back(wall_json(wall));
    for (const Block& column : storey.columns) truth["columns"].push_back(block_json(column));
    for (const Block& piece : storey.furniture) truth["furniture"].push_back(block_json(piece));
    for (const auto& outline : storey.outlines) {
      json corners = json::array();
      for (const Eigen::Vector2d& p : outline) corners.push_back(point(p));
      truth["storeys"].push_back({{"name", storey.name},
                                  {"elevation", storey.elevation},
                                  {"height", storey.height},
                                  {"floor", storey.floor},
                                  {"ceiling", storey.ceiling},
                                  {"floor_shape", shape_json(storey.floor_shape)},
                                  {"ceiling_shape", shape_json(storey.ceiling_shape)},
                                  {"outline", corners}});
    }
  }
  for (const Surface& surface : surfaces_of(world)) truth["surfaces"].push_back(surface_json(surface));
  truth["sensor"] = sensor_json(lidar);
  truth["duration"] = duration;
  truth["length"] = motion.length();
  const Pose start = motion.pose_at(0);
  truth["start"] = {start.translation.x(), start.translation.y(), start.translation.z(), world.route.start_heading};
  return truth.dump(1);
}

}  // namespace sgraph::sim
