#pragma once

#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// The fixed transforms of a recording.
class StaticTransforms {
 public:
  /// A transform that is no rigid motion is left out, and so is one that contradicts an earlier one between the same frames; `notes` tells.
  void add(const tf2_msgs::TFMessage& message);
  void add(const std::string& parent, const std::string& child, const Pose& T_parent_child);

  /// `T_target_source`, through as many transforms as it takes; identity only for a frame and itself. Throws std::runtime_error that names both
  /// frames and what there is.
  [[nodiscard]] Pose lookup(const std::string& target, const std::string& source) const;
  [[nodiscard]] bool connects(const std::string& target, const std::string& source) const;
  /// What was left out, a sentence each.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  tf2::BufferCore buffer_;
  std::map<std::string, Pose> known_;  // by child frame and parent
  std::vector<std::string> notes_;
  std::set<std::string> edges_;  // as text, for the error
};

}  // namespace sgraph
