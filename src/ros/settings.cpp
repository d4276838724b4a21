#include "sgraph_slam/ros/settings.hpp"

#include <array>
#include <charconv>
#include <sstream>

namespace sgraph {

namespace {

std::string number_text(double value) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.begin(), buffer.end(), value).ptr;  // the shortest text that reads back as the same number
  return {buffer.begin(), end};
}

void flatten(XmlRpc::XmlRpcValue tree, const std::string& name, ParamValues& values, std::vector<std::string>& errors) {
  switch (tree.getType()) {
    case XmlRpc::XmlRpcValue::TypeStruct:
      for (auto& [key, value] : tree) flatten(value, name.empty() ? key : name + "." + key, values, errors);
      break;
    case XmlRpc::XmlRpcValue::TypeBoolean: values[name] = static_cast<bool>(tree) ? "true" : "false"; break;
    case XmlRpc::XmlRpcValue::TypeInt: values[name] = std::to_string(static_cast<int>(tree)); break;
    case XmlRpc::XmlRpcValue::TypeDouble: values[name] = number_text(static_cast<double>(tree)); break;
    case XmlRpc::XmlRpcValue::TypeString: values[name] = static_cast<std::string>(tree); break;
    default: errors.push_back(name + ": a number, a word or true/false is wanted here, not a list"); break;
  }
}

}  // namespace

void RosSettings::describe(ParamVisitor& v) {
  v.field("base_frame", base_frame, "The robot's frame; poses are those of this frame.");
  v.field("odom_frame", odom_frame, "Frame in which the odometry runs without jumps.");
  v.field("map_frame", map_frame, "Frame of the map.");
  v.field("lidar_frame", lidar_frame, "The LiDAR's frame; empty: what the clouds say.");
  v.field("base_to_lidar", base_to_lidar,
          "Pose of the LiDAR on the robot, \"x y z yaw pitch roll\" in m and rad, published as a static transform; empty: taken from tf.");
  v.field("map_directory", map_directory, "Folder in which the services save and load maps; they can't leave it.");
  v.field("map", map, "Map file to take up, inside the map directory; empty: a new map.");
  v.choice("map_mode", map_mode, {"continue", "localize"}, "continue: a further session in that map; localize: it stays as it is.");
  v.field("start", start, "Where the robot is in that map: search, first (where the map begins), or \"x y z yaw\" in m and rad.");
  v.field("use_imu", use_imu, "Whether scans wait for the inertial readings of their time.");
  v.field("scan_queue", scan_queue, "", {1, 1000}, "Scans that may wait in front of the prefilter and of the odometry; then the oldest is dropped.");
  v.field("tf_rate", tf_rate, "Hz", {1, 200}, "Rate of the transform from map to odom.");
  v.field("tf_lookahead", tf_lookahead, "s", {0, 2}, "How far ahead of its time that transform is dated, so that nobody has to wait for it.");
  v.field("map_leaf", map_leaf, "m", {0.02, 2}, "Edge of the voxels of which map_points keeps one point each.");
  v.field("storey_gap", storey_gap, "m", {0, 1000}, "Further distance of the building's storeys from each other in `markers`: drawn exploded.");
  v.field("storey", storey, "", {-1, 1000}, "The storey that `markers` show; -1: all.");
  v.field("layer_height", layer_height, "m", {0, 100}, "Distance of the S-Graph's layers above each other in `markers`.");
}

ParamValues to_values(const XmlRpc::XmlRpcValue& tree) {
  ParamValues values;
  std::vector<std::string> errors;
  if (tree.valid()) flatten(tree, "", values, errors);
  if (!errors.empty()) throw ParamError(errors);
  return values;
}

Settings load_settings(const ros::NodeHandle& node) {
  XmlRpc::XmlRpcValue tree;
  node.getParam("config", tree);
  Settings settings;
  apply_values(to_values(tree), [&settings](ParamVisitor& v) {
    settings.params.describe(v);
    v.group("ros", settings.ros, "Frames, rates and queues of the nodelets.");
  });
  if (!settings.ros.base_to_lidar.empty()) parse_mount(settings.ros.base_to_lidar);
  return settings;
}

Pose parse_mount(const std::string& text) {
  std::istringstream stream(text);
  std::array<double, 6> v{};
  for (double& value : v) stream >> value;
  std::string rest;
  if (!stream || stream >> rest) throw ParamError({"base_to_lidar: six numbers \"x y z yaw pitch roll\" wanted, got \"" + text + "\""});
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(v[3], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(v[4], Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(v[5], Eigen::Vector3d::UnitX());
  return {rotation, {v[0], v[1], v[2]}};
}

}  // namespace sgraph
