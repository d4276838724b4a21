#include <fstream>
#include <sstream>

#include "furniture.hpp"
#include "plan.hpp"
#include "route_check.hpp"
#include "sgraph_slam/core/sim/motion.hpp"
#include "sgraph_slam/core/sim/world.hpp"
#include "yaml_fields.hpp"

namespace sgraph::sim {

namespace {

constexpr double degree = M_PI / 180;
constexpr double whole_height = 1e3;  // an opening's top beyond any wall: cut to the wall's height

// One point, or a list of points: the same thing at several places.
std::vector<Eigen::Vector2d> places_of(const Fields& fields, const YAML::Node& at) {
  if (at.IsSequence() && at.size() > 0 && at[0].IsSequence()) return fields.points_of(at, 1);
  return {fields.point_of(at)};
}

void read_walls(Fields& storey_fields, Storey& storey) {
  const double thickness = storey_fields.number("wall_thickness", 0.15, {0.02, 3});
  for (const YAML::Node& node : storey_fields.list_of(storey_fields.need("walls"))) {
    Wall like;
    like.thickness = thickness;
    like.height = storey.height;
    like.bottom = storey.elevation;
    like.line = line_of(node);
    std::vector<Eigen::Vector2d> path;
    if (node.IsSequence()) {
      path = storey_fields.points_of(node, 2);
    } else {
      Fields fields(node, storey_fields.file(), "a wall");
      path = fields.points_of(fields.need("path"), 2);
      like.thickness = fields.number("thickness", thickness, {0.02, 3});
      like.height = fields.number("height", storey.height, {0.1, 100});
      like.glass = fields.flag("glass", false);
      like.material = fields.material("material", Material::plaster);
      fields.finish();
    }
    for (std::size_t i = 1; i < path.size(); ++i) {
      if ((path[i] - path[i - 1]).norm() < 0.05) storey_fields.fail(node, "a wall has two points at the same place");
    }
    for (const Wall& wall : walls_along(path, like)) storey.walls.push_back(wall);
  }
}

// Doors, windows, glass panes and plain openings differ by their defaults.
void read_openings(Fields& storey_fields, Storey& storey, const char* key, const Opening& usual, double usual_width) {
  for (const YAML::Node& node : storey_fields.list_of(storey_fields.take(key))) {
    Opening opening = usual;
    double width = usual_width;
    std::vector<Eigen::Vector2d> places;
    if (node.IsSequence()) {
      places = {storey_fields.point_of(node)};
    } else {
      Fields fields(node, storey_fields.file(), std::string("an entry of `") + key + "`");
      places = places_of(fields, fields.need("at"));
      width = fields.number("width", usual_width, {0.05, 200});
      opening.bottom = fields.number("bottom", usual.bottom, {0, 100});
      opening.top = fields.number("top", usual.top, {0.05, 1000});
      fields.finish();
    }
    for (const Eigen::Vector2d& at : places) {
      const std::string error = cut_opening(storey.walls, at, width, opening);
      if (!error.empty()) storey_fields.fail(node, std::string("`") + key + "`: " + error);
    }
  }
}

void read_columns(Fields& storey_fields, Storey& storey) {
  for (const YAML::Node& node : storey_fields.list_of(storey_fields.take("columns"))) {
    Fields fields(node, storey_fields.file(), "a column");
    Block column;
    column.name = "column";
    column.line = line_of(node);
    column.material = fields.material("material", Material::concrete);
    column.yaw = degree * fields.number("yaw_deg", 0, {-360, 360});
    const double height = fields.number("height", storey.height, {0.1, 100});
    if (fields.has("diameter")) {
      column.round = true;
      const double diameter = fields.number("diameter", 0.4, {0.05, 5});
      column.size = {diameter, diameter, height};
    } else {
      const YAML::Node size = fields.need("size");
      const std::vector<double> sides = size.IsScalar() ? std::vector<double>(2, fields.number("size", 0.4, {0.05, 5})) : fields.numbers(size, 2);
      if (sides[0] < 0.05 || sides[1] < 0.05) fields.fail(size, "a column's `size` must be at least 0.05");
      column.size = {sides[0], sides[1], height};
    }
    for (const Eigen::Vector2d& at : places_of(fields, fields.need("at"))) {
      column.center = {at.x(), at.y(), storey.elevation + 0.5 * height};
      storey.columns.push_back(column);
    }
    fields.finish();
  }
}

void read_furniture(Fields& storey_fields, Storey& storey) {
  for (const YAML::Node& node : storey_fields.list_of(storey_fields.take("furniture"))) {
    Fields fields(node, storey_fields.file(), "a piece of furniture");
    const std::string kind = fields.need("kind").IsScalar() ? fields.text("kind", "") : "";
    const double yaw = degree * fields.number("yaw_deg", 0, {-360, 360});
    const double z = fields.number("z", 0, {0, 100});
    Eigen::Vector3d size = Eigen::Vector3d::Zero();
    if (fields.has("size")) {
      const YAML::Node given = fields.take("size");
      const std::vector<double> values = fields.numbers(given, 3);
      for (int k = 0; k < 3; ++k) {
        size[k] = values[static_cast<std::size_t>(k)];
        if (size[k] <= 0 || size[k] > 100) fields.fail(given, "each of `size` must be between 0 and 100");
      }
    }
    for (const Eigen::Vector2d& at : places_of(fields, fields.need("at"))) {
      std::vector<Block> blocks = furniture_piece(kind, {at.x(), at.y(), storey.elevation + z}, yaw, size);
      if (blocks.empty()) fields.fail(node, "no furniture is called `" + kind + "`; there are " + furniture_names());
      for (Block& block : blocks) {
        block.line = line_of(node);
        storey.furniture.push_back(block);
      }
    }
    fields.finish();
  }
}

void read_places(Fields& storey_fields, const Storey& storey, const char* key, std::vector<Place>& places) {
  const YAML::Node node = storey_fields.take(key);
  if (node.IsNull()) return;
  if (!node.IsMap()) storey_fields.fail(node, std::string("`") + key + "` must be a map from names to points");
  for (const auto& entry : node) {
    const std::string name = entry.first.Scalar();
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
    double yaw = 0;
    if (entry.second.IsMap()) {
      Fields fields(entry.second, storey_fields.file(), name);
      at = fields.point("at");
      yaw = degree * fields.number("yaw_deg", 0, {-360, 360});
      fields.finish();
    } else {
      at = storey_fields.point_of(entry.second);
    }
    std::string error;
    std::optional<Place> place = place_between_walls(storey, at, yaw, error);
    if (!place) storey_fields.fail(entry.first, name + ": " + error);
    place->name = name;
    places.push_back(*place);
  }
}

Storey read_storey(Fields& fields, const std::string& name) {
  Storey storey;
  storey.name = fields.text("storey", name);
  storey.elevation = fields.number("elevation", 0, {-100, 1000});
  storey.height = fields.number("height", 2.8, {1, 50});
  storey.floor = fields.flag("floor", true);
  storey.ceiling = fields.flag("ceiling", true);
  read_walls(fields, storey);
  if (storey.walls.empty()) fields.fail(fields.take("walls"), "a storey needs at least one wall");
  read_openings(fields, storey, "doors", {0, 0, 0, 2.1, false}, 0.95);
  read_openings(fields, storey, "openings", {0, 0, 0, whole_height, false}, 1.5);
  read_openings(fields, storey, "windows", {0, 0, 0.9, 2.2, true}, 1.4);
  read_openings(fields, storey, "glass", {0, 0, 0, whole_height, true}, 2.0);
  read_columns(fields, storey);
  read_furniture(fields, storey);
  const YAML::Node outline = fields.take("outline");
  storey.outline = outline.IsNull() ? bounding_outline(storey.walls) : fields.points_of(outline, 3);
  read_places(fields, storey, "rooms", storey.rooms);
  read_places(fields, storey, "corridors", storey.corridors);
  return storey;
}

void read_storeys(Fields& top, World& world) {
  if (!top.has("storeys")) {
    world.storeys.push_back(read_storey(top, "ground"));
    return;
  }
  for (const YAML::Node& node : top.list_of(top.take("storeys"))) {
    Fields fields(node, top.file(), "a storey");
    world.storeys.push_back(read_storey(fields, "storey " + std::to_string(world.storeys.size())));
    fields.finish();
  }
  if (world.storeys.empty()) top.fail(top.take("storeys"), "`storeys` is empty");
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

Waypoint read_waypoint(const Fields& route, const YAML::Node& node) {
  Waypoint waypoint;
  waypoint.line = line_of(node);
  if (node.IsSequence()) {
    waypoint.position = route.point_of(node);
  } else {
    Fields fields(node, route.file(), "a waypoint");
    waypoint.position = fields.point("at");
    waypoint.wait = fields.number("wait", 0, {0, 600});
    fields.finish();
  }
  return waypoint;
}

void read_route(Fields& top, World& world) {
  Fields fields(top.need("route"), top.file(), "`route`");
  std::vector<Waypoint> round;
  for (const YAML::Node& node : fields.list_of(fields.need("waypoints"))) round.push_back(read_waypoint(fields, node));
  if (round.empty()) fields.fail(fields.take("waypoints"), "`waypoints` is empty");
  const int rounds = fields.integer("rounds", 1, 1, 100);
  const bool back = fields.flag("return", true);
  Route& route = world.route;
  for (int i = 0; i < rounds; ++i) route.waypoints.insert(route.waypoints.end(), round.begin(), round.end());
  if (back && round.size() > 1) route.waypoints.push_back(round.front());
  route.stand = fields.number("stand", 3.0, {0, 600});
  route.stand_end = fields.number("stand_end", 1.0, {0, 600});
  route.duration = fields.number("duration", 0, {0, 7200});
  const int storey = fields.integer("storey", 0, 0, static_cast<int>(world.storeys.size()) - 1);
  route.storey = static_cast<std::size_t>(storey);
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
YAML::Node with_base(const YAML::Node& node, const std::string& file, const std::string& directory, int depth) {
  if (!node.IsMap() || !node["extends"].IsDefined()) return node;
  if (depth > 5 || !node["extends"].IsScalar()) fail_at(file, line_of(node["extends"]), "`extends` must name another world's file, not in a circle");
  const std::string path = directory + "/" + node["extends"].Scalar();
  std::ifstream there(path);
  if (!there) fail_at(file, line_of(node["extends"]), "`extends`: can't read " + path);
  YAML::Node merged = YAML::Clone(with_base(load_text(slurp(path), path), path, directory_of(path), depth + 1));
  if (!merged.IsMap()) fail_at(path, 0, "a world must be a map of keys and values");
  for (const auto& entry : node) {
    if (entry.first.Scalar() != "extends") merged[entry.first.Scalar()] = entry.second;
  }
  return merged;
}

}  // namespace

World parse_world(const std::string& text, const std::string& name, const std::string& directory) {
  World world;
  world.file = name;
  try {
    Fields top(with_base(load_text(text, name), name, directory, 0), name, "a world");
    world.name = top.text("name", "world");
    top.text("description", "");
    world.ground = top.flag("ground", true);
    read_storeys(top, world);
    read_motion(top, world);
    read_lidar(top, world);
    read_route(top, world);
    read_people(top, world);
    top.finish();
  } catch (const YAML::Exception& error) {
    fail_at(name, error.mark.is_null() ? 0 : error.mark.line + 1, error.msg);
  }
  try {
    check_routes(world, Motion(world.route, world.motion, world.storeys[world.route.storey].elevation));
  } catch (const WorldError& error) {
    const std::string message = error.what();
    throw WorldError(message.rfind(name, 0) == 0 ? message : name + ": " + message);
  }
  return world;
}

World read_world(const std::string& path) { return parse_world(slurp(path), path, directory_of(path)); }

World box_world(double length, double width, double height, const std::vector<Eigen::Vector2d>& route) {
  World world;
  world.name = "box";
  Storey storey;
  storey.name = "ground";
  storey.height = height;
  Wall like;
  like.thickness = 0.2;
  like.height = height;
  const double x = 0.5 * (length + like.thickness);
  const double y = 0.5 * (width + like.thickness);
  storey.walls = walls_along({{-x, -y}, {x, -y}, {x, y}, {-x, y}, {-x, -y}}, like);
  storey.outline = bounding_outline(storey.walls);
  std::string error;
  storey.rooms.push_back(*place_between_walls(storey, {0, 0}, 0, error));
  storey.rooms.back().name = "box";
  world.storeys.push_back(storey);
  for (const Eigen::Vector2d& at : route) world.route.waypoints.push_back({at, 0, 0});
  if (route.empty()) world.route.waypoints.push_back({Eigen::Vector2d::Zero(), 0, 0});
  if (route.size() > 1) world.route.start_heading = std::atan2(route[1].y() - route[0].y(), route[1].x() - route[0].x());
  check_routes(world, Motion(world.route, world.motion, 0));
  return world;
}

}  // namespace sgraph::sim
