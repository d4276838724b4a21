#include "sgraph_slam/core/io/storey_view.hpp"

#include <algorithm>

namespace sgraph {

std::set<int> storeys_of(const GraphSnapshot& snapshot) {
  std::set<int> storeys;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    if (keyframe.storey != stairwell) storeys.insert(keyframe.storey);
  }
  return storeys;
}

GraphSnapshot of_storey(const GraphSnapshot& snapshot, int storey) {
  GraphSnapshot part;
  part.version = snapshot.version;
  part.frame = snapshot.frame;
  part.T_map_odom = snapshot.T_map_odom;
  part.dominant_yaw = snapshot.dominant_yaw;
  const auto copy = [storey](const auto& from, auto& to) {
    for (const auto& [id, value] : from) {
      if (value.storey == storey) to.emplace_hint(to.end(), id, value);
    }
  };
  copy(snapshot.keyframes, part.keyframes);
  copy(snapshot.planes, part.planes);
  copy(snapshot.rooms, part.rooms);
  copy(snapshot.corridors, part.corridors);
  copy(snapshot.doors, part.doors);
  for (const SceneStorey& one : snapshot.storeys) {
    if (one.id == storey) part.storeys.push_back(one);
  }
  const auto is_here = [&part](const std::string& name) {
    const std::size_t slash = name.find('/');
    if (slash == std::string::npos) return false;
    const std::int64_t id = std::stoll(name.substr(slash + 1));
    return name.compare(0, slash, "room") == 0 ? part.rooms.count({id}) > 0 : part.corridors.count({id}) > 0;
  };
  for (const SceneOpening& opening : snapshot.openings) {
    if (is_here(opening.from) || is_here(opening.to)) part.openings.push_back(opening);
  }
  return part;
}

GraphSnapshot exploded(GraphSnapshot snapshot, double gap) {
  std::vector<SceneStorey> floors = snapshot.storeys;
  std::sort(floors.begin(), floors.end(), [](const SceneStorey& a, const SceneStorey& b) { return a.z < b.z; });
  if (floors.size() < 2) return snapshot;
  // How many floors lie below a height, with the share of the way to the next.
  const auto rank = [&](double z) {
    std::size_t i = 0;
    while (i + 2 < floors.size() && z > floors[i + 1].z) ++i;
    const double share = (z - floors[i].z) / std::max(0.1, floors[i + 1].z - floors[i].z);
    return static_cast<double>(i) + std::clamp(share, 0.0, 1.0);
  };
  const auto lift = [&](int storey, double z) {
    const auto floor = std::find_if(floors.begin(), floors.end(), [storey](const SceneStorey& one) { return one.id == storey; });
    return gap * (floor != floors.end() ? static_cast<double>(floor - floors.begin()) : rank(z));
  };
  for (auto& [id, keyframe] : snapshot.keyframes) keyframe.T_map_base.translation.z() += lift(keyframe.storey, keyframe.T_map_base.translation.z());
  for (auto& [id, plane] : snapshot.planes) {
    double middle = 0;
    for (const Eigen::Vector3d& corner : plane.extent) middle += corner.z() / static_cast<double>(plane.extent.size());
    const double up = lift(plane.storey, middle);
    for (Eigen::Vector3d& corner : plane.extent) corner.z() += up;
    plane.plane.d -= plane.plane.normal.z() * up;
  }
  for (auto& [id, room] : snapshot.rooms) room.center.z() += lift(room.storey, room.center.z());
  for (auto& [id, corridor] : snapshot.corridors) corridor.center.z() += lift(corridor.storey, corridor.center.z());
  for (auto& [id, door] : snapshot.doors) door.position.z() += lift(door.storey, door.position.z());
  return snapshot;
}

Trajectory path_of(const GraphSnapshot& snapshot, const Trajectory& path) {
  std::set<Stamp> stamps;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    stamps.insert(keyframe.stamp);
    for (const StampedPose& scan : *keyframe.scans) stamps.insert(scan.stamp);
  }
  Trajectory part;
  std::copy_if(path.begin(), path.end(), std::back_inserter(part), [&](const StampedPose& pose) { return stamps.count(pose.stamp) > 0; });
  return part;
}

}  // namespace sgraph
