#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/segments.hpp"
#include "sgraph_slam/ros/messages.hpp"

namespace sgraph {

/// All that the back end needs of one keyframe.
struct MatchedKeyframe {
  ReceivedKeyframe received;  ///< with its cloud
  PlaneSegments segments;
};

/// Puts keyframes together with their clouds and planes, which arrive on topics of their own in any order, by their exact stamp. Complete keyframes
/// come out in order of stamp: one that lacks a part holds back those after it until so many are complete that the part must be taken for lost (a
/// network may lose it; within one process nothing is lost). Clouds and planes to which no keyframe belongs are let go. A keyframe that doesn't come
/// after the last one that came out (id and stamp) starts a new recording: what still waits is forgotten. Not thread-safe.
class KeyframeMatcher {
 public:
  /// `patience`: how many complete keyframes may wait behind an incomplete one.
  explicit KeyframeMatcher(std::size_t patience) : patience_(patience) {}

  void add(ReceivedKeyframe keyframe);
  void add(CloudPtr cloud);
  void add(PlaneSegments segments);

  /// Keyframes that became complete, in order of stamp. Call after each `add`.
  std::vector<MatchedKeyframe> take();

  /// Keyframes given up because a part didn't come.
  [[nodiscard]] std::size_t incomplete() const { return incomplete_; }
  /// Keyframes that wait for a part.
  [[nodiscard]] std::size_t waiting() const;

 private:
  struct Parts {
    std::optional<ReceivedKeyframe> keyframe;
    CloudPtr cloud;
    std::optional<PlaneSegments> segments;

    [[nodiscard]] bool complete() const { return keyframe && cloud && segments; }
  };

  void limit_loose_parts();

  std::size_t patience_;
  std::map<Stamp, Parts> parts_;
  std::optional<Stamp> last_;  // that came out or was given up
  KeyframeId last_id_;
  std::size_t incomplete_ = 0;
};

}  // namespace sgraph
