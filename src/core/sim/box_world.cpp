#include <cmath>

#include "plan.hpp"
#include "regions.hpp"
#include "route_check.hpp"
#include "sgraph_slam/core/sim/motion.hpp"
#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

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
  storey.outlines = {bounding_outline(storey.walls)};
  std::string error;
  storey.rooms.push_back(*place_between_walls(storey, {0, 0}, 0, error));
  storey.rooms.back().name = "box";
  storey.seeds.push_back({"box", "room", Eigen::Vector2d::Zero(), true, 0});
  storey.regions = regions_of(storey, "box");
  world.storeys.push_back(storey);
  for (const Eigen::Vector2d& at : route) world.route.waypoints.push_back({at, 0, 0});
  if (route.empty()) world.route.waypoints.push_back({Eigen::Vector2d::Zero(), 0, 0});
  if (route.size() > 1) world.route.start_heading = std::atan2(route[1].y() - route[0].y(), route[1].x() - route[0].x());
  check_routes(world, motion_along_route(world));
  return world;
}

}  // namespace sgraph::sim
