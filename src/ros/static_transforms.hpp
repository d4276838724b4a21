#pragma once

#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <set>
#include <string>

#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// The fixed transforms of a recording.
class StaticTransforms {
 public:
  void add(const tf2_msgs::TFMessage& message);
  void add(const std::string& parent, const std::string& child, const Pose& T_parent_child);

  /// `T_target_source`, through as many transforms as it takes; identity only for a frame and itself. Throws std::runtime_error that names both
  /// frames and what there is.
  [[nodiscard]] Pose lookup(const std::string& target, const std::string& source) const;

 private:
  tf2::BufferCore buffer_;
  std::set<std::string> edges_;  // as text, for the error
};

}  // namespace sgraph
