#include "static_transforms.hpp"

#include <stdexcept>

#include "sgraph_slam/ros/conversions.hpp"

namespace sgraph {

void StaticTransforms::add(const tf2_msgs::TFMessage& message) {
  for (geometry_msgs::TransformStamped transform : message.transforms) {
    transform.header.frame_id = frame_name(transform.header.frame_id);
    transform.child_frame_id = frame_name(transform.child_frame_id);
    const std::string edge = transform.header.frame_id + " -> " + transform.child_frame_id;
    const auto pose = to_pose(transform.transform);
    if (!pose) {
      notes_.push_back("the transform " + edge + " is left out: " + pose.text);
      continue;
    }
    if (const auto [known, is_new] = known_.try_emplace(edge, pose.value); !is_new) {
      const bool same = (pose.value.translation - known->second.translation).norm() < 1e-4 &&
                        pose.value.rotation.angularDistance(known->second.rotation) < 1e-4;  // [m], [rad] what rounding does
      if (!same) notes_.push_back("the static transform " + edge + " changes within the recording; the first is kept");
      continue;
    }
    buffer_.setTransform(transform, "recording", true);
    edges_.insert(edge);
  }
}

void StaticTransforms::add(const std::string& parent, const std::string& child, const Pose& T_parent_child) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  transform.transform.translation.x = T_parent_child.translation.x();
  transform.transform.translation.y = T_parent_child.translation.y();
  transform.transform.translation.z = T_parent_child.translation.z();
  transform.transform.rotation.x = T_parent_child.rotation.x();
  transform.transform.rotation.y = T_parent_child.rotation.y();
  transform.transform.rotation.z = T_parent_child.rotation.z();
  transform.transform.rotation.w = T_parent_child.rotation.w();
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  add(message);
}

bool StaticTransforms::connects(const std::string& target, const std::string& source) const {
  return target == source || buffer_.canTransform(target, source, ros::Time(0));
}

Pose StaticTransforms::lookup(const std::string& target, const std::string& source) const {
  if (target == source) return {};
  try {
    const auto pose = to_pose(buffer_.lookupTransform(target, source, ros::Time(0)).transform);
    return pose.value;
  } catch (const std::runtime_error&) {  // tf2 says only which frame it missed first
    std::string known;
    for (const std::string& edge : edges_) known += (known.empty() ? "" : ", ") + edge;
    throw std::runtime_error("no transform from " + source + " to " + target + " (/tf_static holds " + (known.empty() ? "nothing" : known) + ")");
  }
}

}  // namespace sgraph
