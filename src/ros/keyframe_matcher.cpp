#include "sgraph_slam/ros/keyframe_matcher.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sgraph {

namespace {

/// Clouds and planes that may wait for their keyframe. It comes at once, but where every scan is segmented most of them belong to none.
constexpr std::ptrdiff_t most_loose_parts = 100;

}  // namespace

void KeyframeMatcher::add(ReceivedKeyframe keyframe) {
  const Stamp stamp = keyframe.keyframe.stamp;
  if (last_ && stamp <= *last_ && !(last_id_ < keyframe.keyframe.id)) {
    Parts arrived_before = std::move(parts_[stamp]);
    parts_.clear();
    parts_[stamp] = std::move(arrived_before);
    last_.reset();
  }
  parts_[stamp].keyframe = std::move(keyframe);
}

void KeyframeMatcher::add(CloudPtr cloud) {
  const Stamp stamp = cloud->stamp;
  parts_[stamp].cloud = std::move(cloud);
  limit_loose_parts();
}

void KeyframeMatcher::add(PlaneSegments segments) {
  const Stamp stamp = segments.stamp;
  parts_[stamp].segments = std::move(segments);
  limit_loose_parts();
}

std::vector<MatchedKeyframe> KeyframeMatcher::take() {
  std::vector<MatchedKeyframe> matched;
  const auto complete = [](const auto& entry) { return entry.second.complete(); };
  while (true) {
    const auto begin = last_ ? parts_.upper_bound(*last_) : parts_.begin();
    const auto next = std::find_if(begin, parts_.end(), [](const auto& entry) { return entry.second.keyframe.has_value(); });
    if (next == parts_.end()) return matched;
    Parts& parts = next->second;
    if (!parts.complete() && std::count_if(next, parts_.end(), complete) <= static_cast<std::ptrdiff_t>(patience_)) return matched;

    last_ = next->first;
    last_id_ = parts.keyframe->keyframe.id;
    if (parts.complete()) {
      parts.keyframe->keyframe.cloud = std::move(parts.cloud);
      matched.push_back({std::move(*parts.keyframe), std::move(*parts.segments)});
    } else {
      ++incomplete_;
    }
    parts_.erase(parts_.begin(), std::next(next));  // keyframes come in order: none will ask for earlier parts
  }
}

std::size_t KeyframeMatcher::waiting() const {
  return static_cast<std::size_t>(std::count_if(parts_.begin(), parts_.end(), [](const auto& entry) { return entry.second.keyframe.has_value(); }));
}

void KeyframeMatcher::limit_loose_parts() {
  const auto loose = [](const auto& entry) { return !entry.second.keyframe; };
  if (std::count_if(parts_.begin(), parts_.end(), loose) > most_loose_parts) parts_.erase(std::find_if(parts_.begin(), parts_.end(), loose));
}

}  // namespace sgraph
