#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/pipeline/run.hpp"

namespace sgraph {

Trajectory corrected_trajectory(const GraphSnapshot& snapshot) {
  Trajectory trajectory;
  const SceneKeyframe* before = nullptr;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const Pose T_map_odom = keyframe.T_map_base * keyframe.T_odom_base.inverse();
    const Pose T_map_odom_before = before != nullptr ? before->T_map_base * before->T_odom_base.inverse() : T_map_odom;
    const double span = before != nullptr ? keyframe.stamp - before->stamp : 0;
    for (const StampedPose& scan : *keyframe.scans) {
      // The two predictions lie close to each other, whereas the corrections themselves are motions about an origin that may be far away.
      const double fraction = span > 0 ? (scan.stamp - before->stamp) / span : 1;
      trajectory.push_back({scan.stamp, interpolate(T_map_odom_before * scan.pose, T_map_odom * scan.pose, fraction)});
    }
    before = &keyframe;
  }
  return trajectory;
}

}  // namespace sgraph
