#include <algorithm>
#include <fstream>
#include <sstream>

#include "route_check.hpp"
#include "sgraph_slam/core/sim/motion.hpp"
#include "sgraph_slam/core/sim/world.hpp"
#include "storey_yaml.hpp"
#include "yaml_fields.hpp"

namespace sgraph::sim {

namespace {

constexpr double degree = M_PI / 180;
using StoreyFrames = std::vector<PlanFrames>;  // of each storey

StoreyFrames read_storeys(Fields& top, World& world) {
  StoreyFrames frames;
  if (!top.has("storeys")) {
    world.storeys.push_back(read_storey(top, "ground", frames.emplace_back()));
    return frames;
  }
  for (const YAML::Node& node : top.list_of(top.take("storeys"))) {
    Fields fields(node, top.file(), "a storey");
    world.storeys.push_back(read_storey(fields, "storey " + std::to_string(world.storeys.size()), frames.emplace_back()));
    fields.finish();
  }
  if (world.storeys.empty()) top.fail(top.take("storeys"), "`storeys` is empty");
  return frames;
}

MotionProfile profile_named(const Fields& fields, const YAML::Node& at, const std::string& name) {
  MotionProfile profile;
  if (name == "legged") return profile;
  if (name == "walker") {  // a person who carries the sensor and hurries
    profile.speed = 1.6;
    profile.acceleration = 1.5;
    profile.turn_rate = 2.7;
    profile.turn_acceleration = 9.0;
    profile.corner = 0.7;
    profile.base_height = 1.0;
    profile.step_frequency = 1.9;
    profile.sway_roll = 1.5 * degree;
    profile.sway_pitch = 1.0 * degree;
    profile.sway_height = 0.025;
    profile.tilt = 5.0 * degree;
    return profile;
  }
  fields.fail(at, "`profile` must be legged or walker");
}

void read_motion(Fields& top, World& world) {
  const YAML::Node node = top.take("motion");
  if (node.IsNull()) return;
  Fields fields(node, top.file(), "`motion`");
  MotionProfile m = profile_named(fields, node, fields.text("profile", "legged"));
  m.speed = fields.number("speed", m.speed, {0.05, 5});
  m.acceleration = fields.number("acceleration", m.acceleration, {0.05, 10});
  m.turn_rate = fields.number("turn_rate", m.turn_rate, {0.05, 10});
  m.turn_acceleration = fields.number("turn_acceleration", m.turn_acceleration, {0.05, 50});
  m.corner = fields.number("corner", m.corner, {0.05, 5});
  m.base_height = fields.number("base_height", m.base_height, {0, 3});
  m.radius = fields.number("radius", m.radius, {0.05, 2});
  m.step_frequency = fields.number("step_frequency", m.step_frequency, {0.1, 5});
  m.sway_roll = degree * fields.number("sway_roll_deg", m.sway_roll / degree, {0, 20});
  m.sway_pitch = degree * fields.number("sway_pitch_deg", m.sway_pitch / degree, {0, 20});
  m.sway_height = fields.number("sway_height", m.sway_height, {0, 0.2});
  m.tilt = degree * fields.number("tilt_deg", m.tilt / degree, {0, 30});
  fields.finish();
  world.motion = m;
}

Eigen::Vector3d point_in_space(Fields& fields, const char* key) {
  const std::vector<double> values = fields.numbers(fields.need(key), 3);
  return {values[0], values[1], values[2]};
}

void read_stairs(Fields& top, World& world) {
  for (const YAML::Node& node : top.list_of(top.take("stairs"))) {
    Fields fields(node, top.file(), "a flight of stairs");
    Flight flight;
    flight.begin = point_in_space(fields, "from");
    flight.end = point_in_space(fields, "to");
    flight.width = fields.number("width", 1.2, {0.4, 30});
    flight.step = fields.number("step", 0.17, {0, 0.4});
    if ((flight.end - flight.begin).head<2>().norm() < 0.3) fields.fail(node, "a flight of stairs must be at least 0.3 m long");
    if (flight.end.z() - flight.begin.z() < 0.05) fields.fail(node, "a flight of stairs must rise `from` low `to` high");
    fields.finish();
    world.flights.push_back(flight);
  }
  for (const YAML::Node& node : top.list_of(top.take("landings"))) {
    Fields fields(node, top.file(), "a landing");
    Landing landing;
    landing.low = fields.point("low");
    landing.high = fields.point("high");
    landing.z = fields.number("z", 0, {-100, 1000});
    if ((landing.high - landing.low).minCoeff() < 0.1) fields.fail(node, "a landing's `high` must lie beyond its `low`");
    fields.finish();
    world.landings.push_back(landing);
  }
}

// Floors and ceilings that the cabin passes through are cut out.
void read_lifts(Fields& top, World& world) {
  for (const YAML::Node& node : top.list_of(top.take("lifts"))) {
    Fields fields(node, top.file(), "a lift");
    Lift lift;
    lift.low = fields.point("low");
    lift.high = fields.point("high");
    lift.door = fields.point("door");
    lift.door_width = fields.number("door_width", lift.door_width, {0.4, 10});
    lift.door_height = fields.number("door_height", lift.door_height, {1, 10});
    lift.height = fields.number("height", lift.height, {1, 10});
    fields.finish();
    if ((lift.high - lift.low).minCoeff() < 0.8) fields.fail(node, "a lift's `high` must lie at least 0.8 m beyond its `low`");
    const double off = std::min((lift.door - lift.low).cwiseAbs().minCoeff(), (lift.door - lift.high).cwiseAbs().minCoeff());
    if (off > 0.01) fields.fail(node, "a lift's `door` must lie on a side of the cabin");
    if (lift.door_height > lift.height) fields.fail(node, "a lift's door is higher than its cabin");
    for (const Storey& storey : world.storeys) lift.floors.push_back(storey.elevation);
    const auto [lowest, highest] = std::minmax_element(lift.floors.begin(), lift.floors.end());
    for (Storey& storey : world.storeys) {
      if (storey.elevation > *lowest) storey.floor_voids.push_back({lift.low, lift.high});
      if (storey.elevation < *highest) storey.ceiling_voids.push_back({lift.low, lift.high});
    }
    world.lifts.push_back(lift);
  }
}

void read_building(Fields& top, World& world) {
  const YAML::Node node = top.take("building");
  if (node.IsNull()) return;
  Fields fields(node, top.file(), "`building`");
  BuildingErrors& e = world.errors;
  e.seed = static_cast<std::uint64_t>(fields.integer("seed", static_cast<int>(e.seed), 0, 1'000'000'000));
  e.lean = degree * fields.number("lean_deg", e.lean / degree, {0, 5});
  e.square = degree * fields.number("square_deg", e.square / degree, {0, 5});
  e.shift = fields.number("shift", e.shift, {0, 0.2});
  e.bow = fields.number("bow", e.bow, {0, 0.1});
  e.slope = fields.number("slope", e.slope, {0, 0.05});
  e.undulation = fields.number("undulation", e.undulation, {0, 0.1});
  fields.finish();
}

void read_lidar(Fields& top, World& world) {
  const YAML::Node node = top.take("lidar");
  if (node.IsNull()) return;
  Fields fields(node, top.file(), "`lidar`");
  Eigen::Vector3d& t = world.T_base_lidar.translation;
  t = {fields.number("x", t.x(), {-2, 2}), fields.number("y", t.y(), {-2, 2}), fields.number("z", t.z(), {-2, 2})};
  world.T_base_lidar.rotation = Eigen::AngleAxisd(degree * fields.number("yaw_deg", 0, {-180, 180}), Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(degree * fields.number("pitch_deg", 0, {-90, 90}), Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(degree * fields.number("roll_deg", 0, {-180, 180}), Eigen::Vector3d::UnitX());
  fields.finish();
}

// `storey` is where the waypoint lies: that of the one before unless it says another.
Waypoint read_waypoint(const Fields& route, const YAML::Node& node, const World& world, const StoreyFrames& all_frames, std::size_t& storey) {
  Waypoint waypoint;
  waypoint.z = world.storeys[storey].elevation;
  waypoint.line = line_of(node);
  if (node.IsSequence()) {
    waypoint.position = route.point_of(node);
    return waypoint;
  }
  Fields fields(node, route.file(), "a waypoint");
  storey = static_cast<std::size_t>(fields.integer("storey", static_cast<int>(storey), 0, static_cast<int>(world.storeys.size()) - 1));
  waypoint.z = fields.number("z", world.storeys[storey].elevation, {-100, 1000});
  const PlanFrames& frames = all_frames[storey];
  const auto frame = frames.find(fields.text("wing", ""));
  if (frame == frames.end()) fields.fail(node, "no wing is called `" + fields.text("wing", "") + "`");
  waypoint.position = frame->second * fields.point("at");
  waypoint.wait = fields.number("wait", 0, {0, 600});
  if (fields.has("ride")) {
    storey = static_cast<std::size_t>(fields.integer("ride", 0, 0, static_cast<int>(world.storeys.size()) - 1));
    waypoint.carried_to = world.storeys[storey].elevation;
    const auto holds = [&](const Lift& lift) {
      return (waypoint.position - lift.low).minCoeff() > 0 && (lift.high - waypoint.position).minCoeff() > 0;
    };
    if (std::none_of(world.lifts.begin(), world.lifts.end(), holds)) fields.fail(node, "the robot can `ride` only in a lift's cabin");
    if (*waypoint.carried_to == waypoint.z) fields.fail(node, "the robot is on the storey that it is to `ride` to");
  }
  fields.finish();
  return waypoint;
}

void read_route(Fields& top, World& world, const StoreyFrames& frames) {
  Fields fields(top.need("route"), top.file(), "`route`");
  const int storey = fields.integer("storey", 0, 0, static_cast<int>(world.storeys.size()) - 1);
  world.route.storey = static_cast<std::size_t>(storey);
  std::vector<Waypoint> round;
  std::size_t current = world.route.storey;
  for (const YAML::Node& node : fields.list_of(fields.need("waypoints"))) round.push_back(read_waypoint(fields, node, world, frames, current));
  if (round.empty()) fields.fail(fields.take("waypoints"), "`waypoints` is empty");
  const int rounds = fields.integer("rounds", 1, 1, 100);
  const bool back = fields.flag("return", true);
  Route& route = world.route;
  for (int i = 0; i < rounds; ++i) route.waypoints.insert(route.waypoints.end(), round.begin(), round.end());
  if (back && round.size() > 1) route.waypoints.push_back(round.front());
  route.stand = fields.number("stand", 3.0, {0, 3600});
  route.stand_end = fields.number("stand_end", 1.0, {0, 600});
  route.duration = fields.number("duration", 0, {0, 7200});
  fields.finish();
  for (std::size_t i = 1; i < route.waypoints.size(); ++i) {
    if ((route.waypoints[i].position - route.waypoints[i - 1].position).norm() < 0.05) {
      fail_at(top.file(), route.waypoints[i].line,
              "this waypoint is at the same place as the one before it (with `rounds` and `return`, don't repeat the first)");
    }
  }
  double heading = 0;
  if (route.waypoints.size() > 1) {
    const Eigen::Vector2d leg = route.waypoints[1].position - route.waypoints[0].position;
    heading = std::atan2(leg.y(), leg.x());
  }
  route.start_heading = degree * top.number("start_heading_deg", heading / degree, {-360, 360});
}

void read_people(Fields& top, World& world) {
  const Storey& storey = world.storeys[world.route.storey];
  for (const YAML::Node& node : top.list_of(top.take("people"))) {
    Fields fields(node, top.file(), "a person");
    Person person;
    person.line = line_of(node);
    person.path = fields.points_of(fields.need("path"), 1);
    for (std::size_t i = 1; i < person.path.size(); ++i) {
      if ((person.path[i] - person.path[i - 1]).norm() < 0.05) fields.fail(node, "a person's path has two points at the same place");
    }
    person.speed = fields.number("speed", 1.0, {0, 4});
    person.offset = fields.number("offset", 0, {0, 1000});
    person.height = fields.number("height", 1.75, {0.5, 2.3});
    person.z = storey.elevation;
    fields.finish();
    world.people.push_back(person);
  }
}

YAML::Node load_text(const std::string& text, const std::string& file) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    fail_at(file, error.mark.is_null() ? 0 : error.mark.line + 1, "not YAML: " + error.msg);
  }
}

std::string slurp(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw WorldError(path + ": can't be read");
  return text.str();
}

std::string directory_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash);
}

// The keys of a world over those of the one that it extends.
YAML::Node with_base(const YAML::Node& node, const std::string& file, const std::string& directory) {
  if (!node.IsMap() || !node["extends"].IsDefined()) return node;
  const YAML::Node name = node["extends"];
  const std::string path = directory + "/" + (name.IsScalar() ? name.Scalar() : "");
  if (!name.IsScalar() || !std::ifstream(path)) fail_at(file, line_of(name), "`extends` must name another world's file: can't read " + path);
  YAML::Node merged = load_text(slurp(path), path);
  if (merged.IsMap() && merged["extends"].IsDefined()) fail_at(file, line_of(name), path + " itself extends another world");
  read_world(path);  // so that what is wrong there is reported with its own file and line
  for (const auto& entry : node) {
    if (entry.first.Scalar() != "extends") merged[entry.first.Scalar()] = entry.second;
  }
  return merged;
}

}  // namespace

World parse_world(const std::string& text, const std::string& file, const std::string& directory) {
  World world;
  std::string name = file;
  try {
    const YAML::Node own = load_text(text, file);
    const YAML::Node merged = with_base(own, file, directory);
    if (own.IsMap() && own["extends"].IsDefined()) name += " (or " + own["extends"].Scalar() + ")";
    world.file = name;
    Fields top(merged, name, "a world");
    world.name = top.text("name", "world");
    top.text("description", "");
    world.ground = top.flag("ground", true);
    const StoreyFrames frames = read_storeys(top, world);
    read_stairs(top, world);
    read_lifts(top, world);
    read_motion(top, world);
    read_building(top, world);
    read_lidar(top, world);
    read_route(top, world, frames);
    read_people(top, world);
    top.finish();
  } catch (const YAML::Exception& error) {
    fail_at(name, error.mark.is_null() ? 0 : error.mark.line + 1, error.msg);
  }
  try {
    check_routes(world, motion_along_route(world));
  } catch (const WorldError& error) {
    const std::string message = error.what();
    throw WorldError(message.rfind(name, 0) == 0 ? message : name + ": " + message);
  }
  return world;
}

World read_world(const std::string& path) { return parse_world(slurp(path), path, directory_of(path)); }

}  // namespace sgraph::sim
