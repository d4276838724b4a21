#include <cmath>
#include <nlohmann/json.hpp>

#include "plan.hpp"
#include "regions.hpp"
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
bool visited(const Place& place, const std::vector<Eigen::Vector3d>& way) {
  for (const Eigen::Vector3d& p : way) {
    if (p.z() < place.z || p.z() > place.z + place.height) continue;
    const Eigen::Vector2d inside = Eigen::Rotation2Dd(-place.yaw) * (p.head<2>() - place.center);
    if (std::abs(inside.x()) < 0.5 * place.width.x() && std::abs(inside.y()) < 0.5 * place.width.y()) return true;
  }
  return false;
}

// Which regions of a storey the robot comes into: its middle at least this far from the walls, so that standing in a door is not enough.
std::vector<bool> entered_regions(const Storey& storey, const std::vector<Eigen::Vector3d>& way) {
  constexpr double margin = 0.3;
  std::vector<bool> entered(storey.regions.size(), false);
  for (const Eigen::Vector3d& p : way) {
    if (p.z() < storey.elevation || p.z() > storey.elevation + storey.height) continue;
    const int at = region_at(storey.regions, p.head<2>(), margin);
    if (at >= 0) entered[static_cast<std::size_t>(at)] = true;
  }
  return entered;
}

json ring_json(const std::vector<Eigen::Vector2d>& ring) {
  json corners = json::array();
  for (const Eigen::Vector2d& p : ring) corners.push_back(point(p));
  return corners;
}

void add_regions(json& truth, const Storey& storey, std::size_t number, const std::vector<bool>& entered) {
  for (std::size_t i = 0; i < storey.regions.size(); ++i) {
    const Region& region = storey.regions[i];
    json holes = json::array();
    for (const auto& hole : region.holes) holes.push_back(ring_json(hole));
    truth["places"].push_back({{"id", region.name},
                               {"kind", region.kind},
                               {"storey", number},
                               {"polygon", ring_json(region.outline)},
                               {"holes", holes},
                               {"area", region.area},
                               {"z", storey.elevation},
                               {"height", storey.height},
                               {"entered", static_cast<bool>(entered[i])}});
  }
}

// Doors that somebody who walks the route must find: as wide as a door, and of a place that the robot enters. Wider ones and those of other places
// are listed, but not wanted.
void add_doors(json& truth, const Storey& storey, std::size_t number, const std::vector<bool>& entered) {
  constexpr double narrowest = 0.6;
  constexpr double widest = 1.6;
  const auto is_entered = [&entered](int region) { return region >= 0 && entered[static_cast<std::size_t>(region)]; };
  const auto name_of = [&storey](int region) { return region >= 0 ? json(storey.regions[static_cast<std::size_t>(region)].name) : json(); };
  for (const Doorway& door : doorways_of(storey)) {
    const bool wanted = !door.closed && door.width >= narrowest && door.width <= widest && (is_entered(door.from) || is_entered(door.to));
    truth["doors"].push_back({{"id", "door " + std::to_string(truth["doors"].size() + 1)},
                              {"position", {door.position.x(), door.position.y(), storey.elevation}},
                              {"yaw", door.yaw},
                              {"width", door.width},
                              {"height", door.height},
                              {"from", name_of(door.from)},
                              {"to", name_of(door.to)},
                              {"storey", number},
                              {"closed", door.closed},
                              {"wanted", wanted}});
  }
}

// On which storey the robot is, by seconds from the start; null on stairs and ramps: farther than 10 cm from every floor.
json storeys_json(const World& world, const std::vector<Eigen::Vector3d>& way) {
  constexpr double near = 0.1;
  constexpr double step = 0.1;  // of the way [s]
  json stretches = json::array();
  for (std::size_t i = 0; i < way.size(); ++i) {
    json storey;
    for (std::size_t k = 0; k < world.storeys.size(); ++k) {
      if (std::abs(way[i].z() - world.motion.base_height - world.storeys[k].elevation) < near) storey = k;
    }
    if (stretches.empty() || stretches.back()["storey"] != storey)
      stretches.push_back({{"begin", step * static_cast<double>(i)}, {"storey", storey}});
    stretches.back()["end"] = step * static_cast<double>(i);
  }
  return stretches;
}

json session_json(const Session& session) {
  json moved = json::array();
  for (const FurnitureMove& m : session.moved) moved.push_back({{"kind", m.name}, {"from", point(m.from)}, {"to", point(m.to)}});
  return {{"seed", session.seed}, {"moved", moved}, {"closed_doors", ring_json(session.closed_doors)}};
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
                {"places", json::array()},
                {"doors", json::array()},
                {"walls", json::array()},
                {"columns", json::array()},
                {"furniture", json::array()},
                {"stairs", json::array()},
                {"storeys", json::array()},
                {"surfaces", json::array()}};
  std::vector<Eigen::Vector3d> way;
  for (double t = 0; t <= duration; t += 0.1) way.push_back(motion.pose_at(t).translation);
  for (std::size_t number = 0; number < world.storeys.size(); ++number) {
    const Storey& storey = world.storeys[number];
    const std::vector<bool> entered = entered_regions(storey, way);
    add_regions(truth, storey, number, entered);
    add_doors(truth, storey, number, entered);
    for (const Place& place : storey.rooms) truth[visited(place, way) ? "rooms" : "other_rooms"].push_back(place_json(place));
    for (const Place& place : storey.corridors) truth[visited(place, way) ? "corridors" : "other_corridors"].push_back(place_json(place));
    for (const Wall& wall : storey.walls) truth["walls"].push_back(wall_json(wall));
    for (const Block& column : storey.columns) truth["columns"].push_back(block_json(column));
    for (const Block& piece : storey.furniture) truth["furniture"].push_back(block_json(piece));
    for (const auto& outline : storey.outlines) {
      json corners = json::array();
      for (const Eigen::Vector2d& p : outline) corners.push_back(point(p));
      truth["storeys"].push_back({{"name", storey.name},
                                  {"storey", number},
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
  if (world.ground) truth["ground"] = ground_height(world);
  for (const Block& step : stairs_of(world, true)) truth["stairs"].push_back(block_json(step));
  truth["storey_of_path"] = storeys_json(world, way);
  truth["session"] = session_json(world.session);
  truth["sensor"] = sensor_json(lidar);
  truth["duration"] = duration;
  truth["length"] = motion.length();
  const Pose start = motion.pose_at(0);
  truth["start"] = {start.translation.x(), start.translation.y(), start.translation.z(), world.route.start_heading};
  return truth.dump(1);
}

}  // namespace sgraph::sim
