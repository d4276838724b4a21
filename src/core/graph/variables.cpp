#include "sgraph_slam/core/graph/variables.hpp"

#include <cmath>

namespace sgraph {
namespace {

Eigen::Vector3d heading(double yaw) { return {std::cos(yaw), std::sin(yaw), 0.0}; }
Eigen::Vector3d left_of(double yaw) { return {-std::sin(yaw), std::cos(yaw), 0.0}; }

}  // namespace

Room Room::at(const Eigen::Vector3d& center, double yaw, const Eigen::Vector2d& width) {
  return {yaw, center.z(), {heading(yaw).dot(center), left_of(yaw).dot(center)}, width};
}

Eigen::Vector3d Room::axis(int index) const { return index == 0 ? heading(yaw) : left_of(yaw); }

Eigen::Vector3d Room::center() const { return position.x() * axis(0) + position.y() * axis(1) + Eigen::Vector3d(0, 0, z); }

Corridor Corridor::at(const Eigen::Vector3d& center, double yaw, double width) {
  return {yaw, heading(yaw).dot(center), center.z(), left_of(yaw).dot(center), width};
}

Eigen::Vector3d Corridor::direction() const { return heading(yaw); }
Eigen::Vector3d Corridor::across() const { return left_of(yaw); }

Eigen::Vector3d Corridor::center() const { return along * direction() + position * across() + Eigen::Vector3d(0, 0, z); }

bool operator==(const Room& a, const Room& b) { return a.yaw == b.yaw && a.z == b.z && a.position == b.position && a.width == b.width; }

bool operator==(const Corridor& a, const Corridor& b) {
  return a.yaw == b.yaw && a.along == b.along && a.z == b.z && a.position == b.position && a.width == b.width;
}

int tangent_size(const VariableId& id) {
  constexpr int sizes[] = {6, 3, 4, 2};
  return sizes[id.index()];
}

const char* type_name(const VariableId& id) {
  constexpr const char* names[] = {"keyframe", "plane", "room", "corridor"};
  return names[id.index()];
}

std::string to_string(const VariableId& id) {
  const std::int64_t value = std::visit([](const auto& typed) { return typed.value; }, id);
  return std::string(type_name(id)) + "/" + std::to_string(value);
}

}  // namespace sgraph
