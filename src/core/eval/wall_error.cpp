#include "sgraph_slam/core/eval/wall_error.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "sgraph_slam/core/types/plane.hpp"

namespace sgraph {
namespace {

constexpr double least_common = 0.5;      // [m]
constexpr double farthest = 0.1;          // [m]
constexpr double reference_height = 1.2;  // above the wall's bottom, where distances are taken [m]
const double steepest = std::sin(15 * M_PI / 180);
const double largest_turn = 5 * M_PI / 180;

struct Placed {  // a mapped plane in the frame of the truth
  std::int64_t id;
  Plane plane;
  std::vector<Eigen::Vector2d> outline;
};

struct Fit {
  double common;  // [m]
  std::size_t plane;
};

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

double distance_at(const Plane& plane, const WallFace& face, double along) {
  const Eigen::Vector2d p = face.begin + along * face.direction();
  return plane.distance({p.x(), p.y(), face.bottom + reference_height});
}

// Length of the stretch that plane and face have in common; 0 when the plane doesn't lie on the face.
double common_stretch(const Placed& placed, const WallFace& face) {
  const Eigen::Vector3d normal(face.normal.x(), face.normal.y(), 0);
  if (placed.outline.empty() || angle_between(placed.plane.normal, normal) > largest_turn) return 0;
  double low = face.length();
  double high = 0;
  for (const Eigen::Vector2d& corner : placed.outline) {
    const double along = face.direction().dot(corner - face.begin);
    low = std::min(low, along);
    high = std::max(high, along);
  }
  low = std::max(low, 0.0);
  high = std::min(high, face.length());
  if (high - low < least_common || std::abs(distance_at(placed.plane, face, 0.5 * (low + high))) > farthest) return 0;
  return high - low;
}

std::vector<Placed> vertical_planes(const std::vector<ScenePlane>& planes, const Pose& T_truth_map) {
  std::vector<Placed> placed;
  for (const ScenePlane& p : planes) {
    const Plane plane = T_truth_map * p.plane;
    if (std::abs(plane.normal.z()) > steepest) continue;
    Placed one{p.id.value, plane, {}};
    for (const Eigen::Vector3d& corner : p.extent) one.outline.emplace_back((T_truth_map * corner).head<2>());
    placed.push_back(std::move(one));
  }
  return placed;
}

}  // namespace

Statistics WallScore::normal_error_deg() const {
  std::vector<double> values;
  for (const WallMatch& m : matches) values.push_back(m.normal_error * 180 / M_PI);
  return statistics_of(std::move(values));
}

Statistics WallScore::position_error() const {
  std::vector<double> values;
  for (const WallMatch& m : matches) values.push_back(m.position_error);
  return statistics_of(std::move(values));
}

WallScore score_walls(const std::vector<ScenePlane>& planes, const Pose& T_truth_map, const std::vector<WallFace>& faces, double seen_length) {
  const std::vector<Placed> placed = vertical_planes(planes, T_truth_map);
  WallScore score;
  std::set<std::size_t> on_a_face;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::vector<Fit> fits;
    for (std::size_t p = 0; p < placed.size(); ++p) {
      const double common = common_stretch(placed[p], faces[f]);
      if (common > 0) fits.push_back({common, p}), on_a_face.insert(p);
    }
    if (faces[f].seen_length <= seen_length) continue;
    ++score.faces;
    if (fits.empty()) {
      score.missed.push_back(f);
      continue;
    }
    std::stable_sort(fits.begin(), fits.end(), [](const Fit& a, const Fit& b) { return a.common > b.common; });
    const Placed& best = placed[fits.front().plane];
    WallMatch match;
    match.face = f;
    match.plane = best.id;
    for (std::size_t i = 1; i < fits.size(); ++i) match.more.push_back(placed[fits[i].plane].id);
    match.normal_error = angle_between(best.plane.normal, {faces[f].normal.x(), faces[f].normal.y(), 0});
    match.position_error = std::abs(distance_at(best.plane, faces[f], 0.5 * (faces[f].seen_begin + faces[f].seen_end)));
    score.duplicates += static_cast<int>(match.more.size());
    score.matches.push_back(std::move(match));
  }
  for (std::size_t p = 0; p < placed.size(); ++p) {
    if (on_a_face.count(p)) continue;
    const Placed turned{placed[p].id, {-placed[p].plane.normal, -placed[p].plane.d}, placed[p].outline};
    const bool reversed = std::any_of(faces.begin(), faces.end(), [&turned](const WallFace& face) { return common_stretch(turned, face) > 0; });
    (reversed ? score.reversed_planes : score.other_planes).push_back(placed[p].id);
  }
  return score;
}

}  // namespace sgraph
