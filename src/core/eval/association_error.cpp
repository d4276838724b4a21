#include "sgraph_slam/core/eval/association_error.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

constexpr double same_plane = 0.005;  // [m] between faces that are one plane
constexpr double farthest = 0.15;     // [m] of an observation from the face that it is of
const double largest_turn = 5 * M_PI / 180;

Plane plane_of(const WallFace& face) {
  const Eigen::Vector3d normal(face.normal.x(), face.normal.y(), 0);
  return {normal, -face.normal.dot(face.begin)};
}

// The point of the mapped plane's outline (truth frame) that is nearest to `from`, on the observed plane.
Eigen::Vector3d nearest_on(const std::vector<Eigen::Vector3d>& outline, const Plane& observed, const Eigen::Vector3d& from) {
  const Eigen::Vector3d along = Eigen::Vector3d::UnitZ().cross(observed.normal).normalized();
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Eigen::Vector3d& corner : outline) {
    low = std::min(low, along.dot(corner));
    high = std::max(high, along.dot(corner));
  }
  const Eigen::Vector3d foot = from - observed.distance(from) * observed.normal;
  const double at = along.dot(foot);
  return outline.empty() ? foot : Eigen::Vector3d(foot + (std::clamp(at, low, high) - at) * along);
}

std::optional<std::size_t> line_of(const Plane& observed, const Eigen::Vector3d& at, const FaceLines& lines) {
  std::optional<std::size_t> best;
  double nearest = farthest;
  for (std::size_t i = 0; i < lines.planes.size(); ++i) {
    if (lines.planes[i].normal.dot(observed.normal) < std::cos(largest_turn)) continue;
    const double distance = std::abs(lines.planes[i].distance(at));
    if (distance < nearest) nearest = distance, best = i;
  }
  return best;
}

}  // namespace

FaceLines face_lines(const std::vector<WallFace>& faces) {
  FaceLines lines;
  for (const WallFace& face : faces) {
    const Plane plane = plane_of(face);
    const Eigen::Vector3d begin(face.begin.x(), face.begin.y(), 0);
    const Eigen::Vector3d end(face.end.x(), face.end.y(), 0);
    const auto same = std::find_if(lines.planes.begin(), lines.planes.end(), [&](const Plane& line) {
      return line.normal.dot(plane.normal) > 0.999 && std::abs(line.distance(begin)) < same_plane && std::abs(line.distance(end)) < same_plane;
    });
    lines.of_face.push_back(static_cast<std::size_t>(same - lines.planes.begin()));
    if (same == lines.planes.end()) lines.planes.push_back(plane);
  }
  return lines;
}

std::vector<AssociatedPlane> associated_planes(const GraphSnapshot& snapshot) {
  std::vector<AssociatedPlane> observations;
  for (const auto& [id, factor] : factors_from_json(snapshot.factors_json)) {
    const auto* seen = std::get_if<PosePlane>(&factor.data);
    if (seen == nullptr) continue;
    const auto keyframe = snapshot.keyframes.find(seen->keyframe);
    if (keyframe == snapshot.keyframes.end()) continue;
    observations.push_back({keyframe->second.stamp, seen->plane.value, seen->T_base_lidar * seen->measured});
  }
  return observations;
}

std::vector<std::optional<std::size_t>> true_lines(const std::vector<AssociatedPlane>& observations, const std::vector<ScenePlane>& planes,
                                                   const Trajectory& truth, const Pose& T_truth_map, const FaceLines& lines, const WallScore& walls) {
  std::map<std::int64_t, std::vector<Eigen::Vector3d>> outlines;
  for (const ScenePlane& plane : planes) {
    for (const Eigen::Vector3d& corner : plane.extent) outlines[plane.id.value].push_back(T_truth_map * corner);
  }
  std::set<std::int64_t> on_faces;
  for (const WallMatch& match : walls.matches) {
    on_faces.insert(match.plane);
    on_faces.insert(match.more.begin(), match.more.end());
    on_faces.insert(match.from_other_storeys.begin(), match.from_other_storeys.end());
  }
  std::vector<std::optional<std::size_t>> found;
  for (const AssociatedPlane& o : observations) {
    found.emplace_back();
    if (on_faces.count(o.plane) == 0) continue;
    const Pose T_truth_base = pose_at(truth, o.stamp);
    const Plane observed = T_truth_base * o.measured;
    found.back() = line_of(observed, nearest_on(outlines[o.plane], observed, T_truth_base.translation), lines);
  }
  return found;
}

AssociationScore score_associations(const std::vector<AssociatedPlane>& observations, const std::vector<ScenePlane>& planes, const Trajectory& truth,
                                    const Pose& T_truth_map, const std::vector<WallFace>& faces, const WallScore& walls) {
  const std::vector<std::optional<std::size_t>> lines = true_lines(observations, planes, truth, T_truth_map, face_lines(faces), walls);
  std::set<std::int64_t> main;
  std::set<std::int64_t> duplicates;
  for (const WallMatch& match : walls.matches) {
    main.insert(match.plane);
    main.insert(match.from_other_storeys.begin(), match.from_other_storeys.end());
    duplicates.insert(match.more.begin(), match.more.end());
  }
  std::map<std::int64_t, std::map<std::size_t, int>> votes;
  std::map<std::int64_t, int> counts;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const std::int64_t plane = observations[i].plane;
    if (main.count(plane) == 0 && duplicates.count(plane) == 0) continue;
    ++counts[plane];
    if (lines[i]) ++votes[plane][*lines[i]];
  }
  AssociationScore score;
  for (const auto& [plane, count] : counts) {
    score.observations += count;
    if (main.count(plane) == 0) {
      score.split += count;
      continue;
    }
    int most = 0;
    for (const auto& [line, n] : votes[plane]) most = std::max(most, n);
    score.wrong_face += count - most;
  }
  return score;
}

}  // namespace sgraph
