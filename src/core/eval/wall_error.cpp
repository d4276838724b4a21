#include "sgraph_slam/core/eval/wall_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <tuple>

#include "sgraph_slam/core/types/plane.hpp"

namespace sgraph {
namespace {

constexpr double least_common = 0.5;      // [m]
constexpr double farthest = 0.1;          // [m]
constexpr double nearer = 0.02;           // [m] by which another face must be nearer for a plane to be of that one only
constexpr double reference_height = 1.2;  // above the wall's bottom, where distances are taken [m]
const double steepest = std::sin(15 * M_PI / 180);
const double largest_turn = 5 * M_PI / 180;

struct Placed {  // a mapped plane in the frame of the truth
  std::int64_t id;
  Plane plane;
  std::vector<Eigen::Vector2d> outline;
  double low;  // z of its outline [m]
  double high;
  int storey = 0;
};

struct Stretch {  // along a face, from its begin [m]
  double low = 0;
  double high = 0;
  [[nodiscard]] double length() const { return std::max(0.0, high - low); }
  [[nodiscard]] double middle() const { return 0.5 * (low + high); }
};

struct BlockSide {
  Eigen::Vector2d begin, end, normal;
  double bottom, top;
};

struct Fit {
  double common;    // [m]
  double distance;  // [m]
  std::size_t plane;
};

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

double distance_at(const Plane& plane, const WallFace& face, double along) {
  const Eigen::Vector2d p = face.begin + along * face.direction();
  return plane.distance({p.x(), p.y(), face.bottom + reference_height});
}

std::vector<BlockSide> sides_of(const std::vector<PlanBlock>& blocks) {
  std::vector<BlockSide> sides;
  for (const PlanBlock& block : blocks) {
    if (block.round) continue;
    const Eigen::Vector2d x(std::cos(block.yaw), std::sin(block.yaw));
    const Eigen::Vector2d y(-x.y(), x.x());
    const Eigen::Vector2d center = block.center.head<2>();
    for (const auto& [out, along, half_out, half_along] :
         {std::tuple{x, y, block.size.x() / 2, block.size.y() / 2}, std::tuple{y, Eigen::Vector2d(-x), block.size.y() / 2, block.size.x() / 2}}) {
      for (const double sign : {1.0, -1.0}) {
        const Eigen::Vector2d middle = center + sign * half_out * out;
        sides.push_back({middle - half_along * along, middle + half_along * along, sign * out, block.center.z() - block.size.z() / 2,
                         block.center.z() + block.size.z() / 2});
      }
    }
  }
  return sides;
}

// Whether the plane is of furniture or a column rather than of the face on which it lies over this stretch.
bool on_blocks(const Placed& placed, const WallFace& face, Stretch common, const std::vector<BlockSide>& sides) {
  double length = 0;
  for (const BlockSide& side : sides) {
    if (side.normal.dot(face.normal) < std::cos(largest_turn)) continue;
    if (std::min(side.top, placed.high) - std::max(side.bottom, placed.low) < 0.5 * (placed.high - placed.low)) continue;
    const double a = face.direction().dot(side.begin - face.begin);
    const double b = face.direction().dot(side.end - face.begin);
    const Stretch shared{std::max(common.low, std::min(a, b)), std::min(common.high, std::max(a, b))};
    if (shared.length() == 0) continue;
    const double before = face.normal.dot(0.5 * (side.begin + side.end) - face.begin);  // of the wall
    const double distance = -distance_at(placed.plane, face, shared.middle());          // of the plane before the wall
    if (std::abs(distance - before) < std::abs(distance)) length += shared.length();
  }
  return length > 0.5 * common.length();
}

// What plane and face have in common; none when the plane doesn't lie on the face.
std::optional<Fit> fit_of(const Placed& placed, const WallFace& face, const std::vector<BlockSide>& sides) {
  const Eigen::Vector3d normal(face.normal.x(), face.normal.y(), 0);
  if (placed.outline.empty() || angle_between(placed.plane.normal, normal) > largest_turn) return std::nullopt;
  double low = face.length();
  double high = 0;
  for (const Eigen::Vector2d& corner : placed.outline) {
    const double along = face.direction().dot(corner - face.begin);
    low = std::min(low, along);
    high = std::max(high, along);
  }
  low = std::max(low, 0.0);
  high = std::min(high, face.length());
  const double distance = std::abs(distance_at(placed.plane, face, 0.5 * (low + high)));
  if (high - low < least_common || distance > farthest || on_blocks(placed, face, {low, high}, sides)) return std::nullopt;
  return Fit{high - low, distance, 0};
}

// The planes on each face. Where walls of different thickness stand in one line, a plane along them is within reach of all their faces but lies on
// the nearest.
std::vector<std::vector<Fit>> fits_on(const std::vector<WallFace>& faces, const std::vector<Placed>& placed, const std::vector<BlockSide>& sides) {
  std::vector<std::vector<Fit>> fits(faces.size());
  for (std::size_t p = 0; p < placed.size(); ++p) {
    std::vector<std::optional<Fit>> on_face;
    double nearest = farthest;
    for (const WallFace& face : faces) {
      on_face.push_back(fit_of(placed[p], face, sides));
      if (on_face.back()) nearest = std::min(nearest, on_face.back()->distance);
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
      if (on_face[f] && on_face[f]->distance <= nearest + nearer) fits[f].push_back({on_face[f]->common, on_face[f]->distance, p});
    }
  }
  return fits;
}

std::vector<Placed> vertical_planes(const std::vector<ScenePlane>& planes, const Pose& T_truth_map) {
  std::vector<Placed> placed;
  for (const ScenePlane& p : planes) {
    const Plane plane = T_truth_map * p.plane;
    if (std::abs(plane.normal.z()) > steepest) continue;
    Placed one{p.id.value, plane, {}, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), p.storey};
    for (const Eigen::Vector3d& corner : p.extent) {
      const Eigen::Vector3d at = T_truth_map * corner;
      one.outline.emplace_back(at.head<2>());
      one.low = std::min(one.low, at.z());
      one.high = std::max(one.high, at.z());
    }
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

WallScore score_walls(const std::vector<ScenePlane>& planes, const Pose& T_truth_map, const std::vector<WallFace>& faces,
                      const std::vector<PlanBlock>& blocks, double seen_length) {
  const std::vector<Placed> placed = vertical_planes(planes, T_truth_map);
  const std::vector<BlockSide> sides = sides_of(blocks);
  WallScore score;
  std::set<std::size_t> on_a_face;
  std::vector<std::vector<Fit>> all_fits = fits_on(faces, placed, sides);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::vector<Fit>& fits = all_fits[f];
    for (const Fit& fit : fits) on_a_face.insert(fit.plane);
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
    std::set<int> storeys{best.storey};
    for (std::size_t i = 1; i < fits.size(); ++i) {
      const Placed& other = placed[fits[i].plane];
      (storeys.insert(other.storey).second ? match.from_other_storeys : match.more).push_back(other.id);
    }
    match.normal_error = angle_between(best.plane.normal, {faces[f].normal.x(), faces[f].normal.y(), 0});
    match.position_error = std::abs(distance_at(best.plane, faces[f], 0.5 * (faces[f].seen_begin + faces[f].seen_end)));
    score.duplicates += static_cast<int>(match.more.size());
    score.matches.push_back(std::move(match));
  }
  for (std::size_t p = 0; p < placed.size(); ++p) {
    if (on_a_face.count(p)) continue;
    const Placed turned{placed[p].id,    {-placed[p].plane.normal, -placed[p].plane.d}, placed[p].outline, placed[p].low, placed[p].high,
                        placed[p].storey};
    const bool reversed = std::any_of(faces.begin(), faces.end(), [&](const WallFace& face) { return fit_of(turned, face, {}).has_value(); });
    (reversed ? score.reversed_planes : score.other_planes).push_back(placed[p].id);
  }
  return score;
}

}  // namespace sgraph
