#include <algorithm>
#include <cmath>
#include <map>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/mapping/map_state.hpp"
#include "sgraph_slam/core/planes/association.hpp"
#include "sgraph_slam/core/planes/passages.hpp"

namespace sgraph {
namespace {

constexpr std::size_t known_better = 5;  // times as many views
constexpr std::size_t few_views = 5;     // of a plane that the robot walked through: with more it is a wall with a passage
constexpr double leaning = 0.026;        // [rad] of a plane against the wall that it lies at
constexpr double returned_path = 20.0;   // seeing a plane again after this way closes a loop [m]

Matrix6 floored(Matrix6 covariance, const Keyframe& keyframe, const FactorParams& params) {
  const double angle = params.keyframe_floor_angle;
  const double distance = params.keyframe_floor_distance;
  covariance.diagonal().head<3>().array() += angle * angle;
  covariance.diagonal().tail<3>().array() += distance * distance;
  for (const Vector6& v : keyframe.degenerate) {
    const double sigma = std::hypot(v.head<3>().norm() * params.degenerate_angle, v.tail<3>().norm() * params.degenerate_distance);
    covariance += sigma * sigma * v * v.transpose();
  }
  return covariance;
}

bool finite(const Pose& pose) {
  return pose.rotation.coeffs().allFinite() && pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1) < 1e-6;
}

bool usable(const PlaneSegment& segment) {
  return segment.plane.normal.allFinite() && std::isfinite(segment.plane.d) && std::abs(segment.plane.normal.norm() - 1) < 1e-6 &&
         segment.covariance.allFinite() && segment.centroid.allFinite() && segment.scatter.allFinite() && segment.extent.size() >= 3;
}

FactorData observation(const MapState& state, KeyframeId keyframe, PlaneId plane, const PlaneSegment& segment) {
  const FactorParams& params = state.params.factors;
  if (params.plane_factor == "points" && segment.count > 0) {
    return PosePlanePoints{keyframe, plane, sqrt_scatter(segment.scatter, params.point_sigma, params.plane_floor_angle, params.plane_floor_distance),
                           state.T_base_lidar};
  }
  const Eigen::Matrix3d covariance = floored_covariance(segment, params.plane_floor_angle, params.plane_floor_distance);
  return PosePlane{keyframe, plane, segment.plane, state.T_base_lidar,
                   SqrtInformation<3>::from_covariance(covariance, Eigen::Vector3d::Constant(1e-6))};
}

std::vector<PlaneCandidate> candidates_of(const MapState& state) {
  std::vector<PlaneCandidate> candidates;
  for (const auto& [id, record] : state.planes.records()) {
    if (const Plane* plane = state.graph.find(id)) candidates.push_back({id, *plane, &record.outline});
  }
  return candidates;
}

// A segment on its way into the graph.
struct View {
  PlaneSegment segment;
  std::vector<Match> matches{};  // planes of the map that it may be of, the likeliest first
  bool unsure = false;           // of its side
  PlaneId plane{};               // that it is taken for
};

// Where the LiDAR was when the scans of a keyframe were taken, in its frame at the keyframe's stamp.
std::vector<Eigen::Vector3d> lidar_origins(const Keyframe& keyframe, const Pose& T_base_lidar) {
  const Pose T_lidar_odom = (keyframe.T_odom_base * T_base_lidar).inverse();
  std::vector<Eigen::Vector3d> origins;
  for (const StampedPose& scan : keyframe.scans) origins.push_back((T_lidar_odom * scan.pose * T_base_lidar).translation);
  return origins;
}

// The likeliest plane for each view, but none for two that are apart: there the one that fits better has it, and the other its next match or none.
void choose_planes(std::vector<View>& views, const MappingParams& params) {
  std::vector<View*> open;
  for (View& view : views) {
    if (!view.matches.empty()) open.push_back(&view);
  }
  std::stable_sort(open.begin(), open.end(),
                   [](const View* a, const View* b) { return a->matches.front().chi_square < b->matches.front().chi_square; });
  std::map<PlaneId, std::vector<MeasuredPlane>> taken;
  for (View* view : open) {
    const MeasuredPlane measured{view->segment.plane,
                                 floored_covariance(view->segment, params.factors.plane_floor_angle, params.factors.plane_floor_distance)};
    for (const Match& match : view->matches) {
      auto& others = taken[match.id];
      const double gate = params.association.chi_square;
      if (std::any_of(others.begin(), others.end(), [&](const MeasuredPlane& other) { return are_apart(measured, other, gate); })) continue;
      view->plane = match.id;
      others.push_back(measured);
      break;
    }
  }
}

// Whether a plane lies beside one that is known much better, in front of it or within it: what segmentation made of a wall and something before it,
// of a wall through a pane, of a person at a wall. Seen more than rarely it may be a wall's thicker part, but not when it leans against the wall.
bool is_ghost(const MapState& state, const PlaneRecord& record, bool rarely_seen) {
  const AssociationParams& params = state.params.association;
  const Plane& plane = *state.graph.find(record.id);
  const Eigen::Vector3d center = outline_center(record.outline);
  for (const auto& [id, other] : state.planes.records()) {
    if (other.keyframes.size() < known_better * record.keyframes.size()) continue;
    const Plane& wall = *state.graph.find(id);
    const double cosine = wall.normal.dot(plane.normal);
    if (cosine < std::cos(params.max_angle) || std::abs(wall.distance(center)) > params.ghost_distance) continue;
    if (!rarely_seen && cosine > std::cos(leaning)) continue;
    if (outline_distance(wall, other.outline, record.outline) == 0) return true;
  }
  return false;
}

// Whether the plane was seen only where the robot has walked.
bool is_walked_through(const PlaneRecord& record, const std::vector<Eigen::Vector2d>& path) {
  if (!record.wall) return false;
  Wall wall = *record.wall;
  open_passages(wall, path);
  return wall.support.empty();
}

}  // namespace

Applied commit(MapState& state, const Transaction& transaction) {
  const Applied applied = state.graph.apply(transaction);
  if (!applied.ok())
    state.log.push_back({state.newest(), false, transaction.reason, std::string(to_string(applied.refusal)) + ": " + applied.detail});
  return applied;
}

void add_factor(Transaction& edit, const FactorData& data, const RobustLoss& loss) {
  Factor& factor = edit.factors.emplace_back();
  factor.data = data;
  factor.loss = loss;
}

bool add_keyframe(MapState& state, const Keyframe& keyframe) {
  const auto refuse = [&](const char* reason) {
    state.log.push_back({state.newest(), false, "keyframe/" + std::to_string(keyframe.id.value), reason});
    return false;
  };
  if (!finite(keyframe.T_odom_base) || !keyframe.covariance.allFinite()) return refuse("not finite");
  if (!keyframe.id.valid() || (!state.keyframes.empty() && !(state.newest() < keyframe.id))) return refuse("not newer than the last");
  const Pose claimed = state.keyframes.empty() ? Pose{} : state.keyframes.rbegin()->second.T_odom_base.inverse() * keyframe.T_odom_base;
  const KeyframeMotion motion = state.submap.add(keyframe, {claimed, keyframe.covariance});
  const Matrix6 covariance = floored(motion.covariance, keyframe, state.params.factors);
  Transaction edit;
  edit.reason = "keyframe/" + std::to_string(keyframe.id.value);
  if (state.keyframes.empty()) {
    edit.keyframes[keyframe.id] = state.T_map_odom * keyframe.T_odom_base;
  } else {
    const Keyframe& last = state.keyframes.rbegin()->second;
    edit.keyframes[keyframe.id] = *state.graph.find(last.id) * motion.T_last_now;
    Vector6 tiny;
    tiny << Eigen::Vector3d::Constant(1e-6), Eigen::Vector3d::Constant(1e-6);
    add_factor(edit, Se3Between{last.id, keyframe.id, motion.T_last_now, SqrtInformation<6>::from_covariance(covariance, tiny),
                                Se3Between::Source::odometry});
  }
  if (!commit(state, edit).ok()) return false;
  state.drift.add(keyframe.id, keyframe.T_odom_base, covariance);
  state.keyframes[keyframe.id] = keyframe;
  return true;
}

AssociationResult add_observations(MapState& state, const PlaneSegments& segments) {
  AssociationResult result;
  const KeyframeId now = state.newest();
  const AssociationParams& params = state.params.association;
  const Pose T_map_base = *state.graph.find(now);
  const std::vector<PlaneCandidate> candidates = candidates_of(state);
  const PlaneUncertainty uncertainty(state.graph, state.planes, state.drift, state.marginals, now);
  const auto predicted = [&uncertainty](PlaneId id, const Innovation& innovation) { return uncertainty(id, innovation); };

  const std::vector<Eigen::Vector3d> origins = lidar_origins(state.keyframes.rbegin()->second, state.T_base_lidar);
  const double usual = usual_sigma(segments.segments);
  std::vector<View> views;
  for (const PlaneSegment& raw : segments.segments) {
    View view{with_model_error(raw, usual)};
    if (!usable(view.segment)) {
      ++result.ignored;
      continue;
    }
    view.matches = associate(view.segment, T_map_base, state.T_base_lidar, candidates, predicted, params);
    view.unsure = side_is_unsure(view.segment, origins);
    if (view.unsure) {
      PlaneSegment other = flipped(view.segment);
      std::vector<Match> from_behind = associate(other, T_map_base, state.T_base_lidar, candidates, predicted, params);
      if (!from_behind.empty() && (view.matches.empty() || from_behind.front().cost < view.matches.front().cost)) {
        view.matches = std::move(from_behind);
        view.segment = std::move(other);
      }
    }
    views.push_back(std::move(view));
  }
  choose_planes(views, state.params);

  Transaction edit;
  edit.reason = "planes of keyframe/" + std::to_string(now.value);
  const RobustLoss loss{loss_kind_from(state.params.factors.plane_loss), state.params.factors.plane_loss_scale};
  for (View& view : views) {
    if (view.plane.valid()) {
      ++result.matched;
      result.returned |= state.drift.path(state.planes.find(view.plane)->last_seen, now) > returned_path;
    } else if (!view.unsure && outline_area(view.segment.extent) >= params.min_new_area) {
      view.plane = state.graph.new_plane_id();
      edit.planes[view.plane] = T_map_base * state.T_base_lidar * view.segment.plane;
      ++result.created;
    } else {
      ++result.ignored;
      continue;
    }
    add_factor(edit, observation(state, now, view.plane, view.segment), loss);
  }
  views.erase(std::remove_if(views.begin(), views.end(), [](const View& view) { return !view.plane.valid(); }), views.end());
  const Applied applied = commit(state, edit);
  if (!applied.ok()) return {};
  for (std::size_t i = 0; i < views.size(); ++i) {
    const PlaneSegment& segment = views[i].segment;
    const Eigen::Matrix3d covariance = floored_covariance(segment, state.params.factors.plane_floor_angle, state.params.factors.plane_floor_distance);
    state.planes.observe(state.graph, views[i].plane, now, applied.factors[i], segment.extent, state.T_base_lidar, segment.plane, covariance);
    state.planes.reclassify(state.graph, views[i].plane, state.frame);
    result.seen.insert(views[i].plane);
  }
  return result;
}

std::vector<Eigen::Vector2d> path_of(const MapState& state) {
  std::vector<Eigen::Vector2d> path;
  for (const auto& [id, T_map_base] : state.graph.keyframes()) path.emplace_back(T_map_base.translation.head<2>());
  return path;
}

int drop_passing_planes(MapState& state, bool all) {
  const AssociationParams& params = state.params.association;
  const std::vector<Eigen::Vector2d> path = path_of(state);
  Transaction edit;
  edit.reason = "planes seen in passing";
  std::vector<PlaneId> passing;
  for (const auto& [id, record] : state.planes.records()) {
    if (record.keyframes.size() <= few_views && is_walked_through(record, path)) {
      edit.remove_variables.emplace_back(id);
      passing.push_back(id);
      state.log.push_back({state.newest(), false, "plane/" + std::to_string(id.value), "dropped: the robot has walked through it"});
      continue;
    }
    const auto unseen = state.newest().value - record.last_seen.value;
    const bool rarely_seen = record.keyframes.size() <= static_cast<std::size_t>(params.drop_views);
    const bool small_and_old = rarely_seen && unseen >= params.drop_after && outline_area(record.outline) < params.drop_area;
    if (!small_and_old && (!(all || unseen >= params.drop_ghost_after) || !is_ghost(state, record, rarely_seen))) continue;
    edit.remove_variables.emplace_back(id);
    passing.push_back(id);
  }
  if (passing.empty() || !commit(state, edit).ok()) return 0;
  for (const PlaneId id : passing) state.planes.erase(id);
  return static_cast<int>(passing.size());
}

}  // namespace sgraph
