#include "sgraph_slam/core/planes/add_observations.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "sgraph_slam/core/planes/association.hpp"
#include "sgraph_slam/core/planes/plane_uncertainty.hpp"

namespace sgraph {
namespace {

constexpr double returned_path = 20.0;  // seeing a plane again after this way closes a loop [m]

bool usable(const PlaneSegment& segment) {
  return segment.plane.normal.allFinite() && std::isfinite(segment.plane.d) && std::abs(segment.plane.normal.norm() - 1) < 1e-6 &&
         segment.covariance.allFinite() && segment.centroid.allFinite() && segment.scatter.allFinite() && segment.extent.size() >= 3;
}

FactorData observation(const PlaneLayer& planes, KeyframeId keyframe, PlaneId plane, const PlaneSegment& segment) {
  const FactorParams& params = planes.params.factors;
  if (params.plane_factor == "points" && segment.count > 0) {
    return PosePlanePoints{keyframe, plane, sqrt_scatter(segment.scatter, params.point_sigma, params.plane_floor_angle, params.plane_floor_distance),
                           planes.T_base_lidar};
  }
  const Eigen::Matrix3d covariance = floored_covariance(segment, params.plane_floor_angle, params.plane_floor_distance);
  return PosePlane{keyframe, plane, segment.plane, planes.T_base_lidar,
                   SqrtInformation<3>::from_covariance(covariance, Eigen::Vector3d::Constant(1e-6))};
}

// The planes that the segment may be of, by where it is. On the plane they are `extent_margin` apart at most; off it the segment reaches as far as
// its centroid may be off and its length at the largest angle.
std::vector<PlaneCandidate> candidates_of(const Graph& graph, const PlaneMap& planes, const Pose& T_map_lidar, const PlaneSegment& segment,
                                          int storey, const AssociationParams& params) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& corner : segment.extent) box.extend(T_map_lidar * corner);
  const double off = params.max_distance + std::sin(params.max_angle) * box.diagonal().norm() + PlaneMap::stale;
  std::vector<PlaneCandidate> candidates;
  for (const PlaneId id : planes.index().near(box, std::hypot(params.extent_margin, off))) {
    if (planes.find(id)->storey != storey) continue;
    if (const Plane* plane = graph.find(id)) candidates.push_back({id, *plane, &planes.find(id)->outline});
  }
  return candidates;
}

// A segment on its way into the graph.
struct View {
  std::size_t index;  // of the segment among the keyframe's
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
void choose_planes(std::vector<View>& views, const PlaneLayerParams& params) {
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

}  // namespace

AssociationResult add_observations(Committer& committer, PlaneLayer& planes, const Keyframe& newest, const PlaneSegments& segments) {
  AssociationResult result;
  const KeyframeId now = newest.id;
  const Graph& graph = committer.graph;
  const AssociationParams& params = planes.params.association;
  const Pose T_map_base = *graph.find(now);
  const int storey = planes.storey_of(now);
  const PlaneUncertainty uncertainty(graph, planes.map, planes.drift, planes.marginals, now);
  const auto predicted = [&uncertainty](PlaneId id, const Innovation& innovation) { return uncertainty(id, innovation); };

  const std::vector<Eigen::Vector3d> origins = lidar_origins(newest, planes.T_base_lidar);
  std::vector<View> views;
  for (std::size_t i = 0; i < segments.segments.size(); ++i) {
    View view{i, segments.segments[i]};
    if (!usable(view.segment)) {
      ++result.ignored;
      continue;
    }
    const std::vector<PlaneCandidate> candidates = candidates_of(graph, planes.map, T_map_base * planes.T_base_lidar, view.segment, storey, params);
    view.matches = associate(view.segment, T_map_base, planes.T_base_lidar, candidates, predicted, params);
    view.unsure = side_is_unsure(view.segment, origins);
    if (view.unsure) {
      PlaneSegment other = flipped(view.segment);
      std::vector<Match> from_behind = associate(other, T_map_base, planes.T_base_lidar, candidates, predicted, params);
      if (!from_behind.empty() && (view.matches.empty() || from_behind.front().cost < view.matches.front().cost)) {
        view.matches = std::move(from_behind);
        view.segment = std::move(other);
      }
    }
    views.push_back(std::move(view));
  }
  choose_planes(views, planes.params);

  Transaction edit;
  edit.reason = "planes of keyframe/" + std::to_string(now.value);
  const RobustLoss loss{loss_kind_from(planes.params.factors.plane_loss), planes.params.factors.plane_loss_scale};
  for (View& view : views) {
    if (view.plane.valid()) {
      ++result.matched;
      result.returned |= planes.drift.path(planes.map.find(view.plane)->last_seen, now) > returned_path;
    } else if (!view.unsure && outline_area(view.segment.extent) >= params.min_new_area) {
      view.plane = committer.graph.new_plane_id();
      edit.planes[view.plane] = T_map_base * planes.T_base_lidar * view.segment.plane;
      ++result.created;
    } else {
      ++result.ignored;
      continue;
    }
    add_factor(edit, observation(planes, now, view.plane, view.segment), loss);
  }
  views.erase(std::remove_if(views.begin(), views.end(), [](const View& view) { return !view.plane.valid(); }), views.end());
  const Applied applied = committer.commit(edit);
  if (!applied.ok()) return {};
  result.planes.resize(segments.segments.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const PlaneSegment& segment = views[i].segment;
    const Eigen::Matrix3d covariance =
        floored_covariance(segment, planes.params.factors.plane_floor_angle, planes.params.factors.plane_floor_distance);
    planes.map.observe(graph, views[i].plane, now, applied.factors[i], segment.extent, planes.T_base_lidar, segment.plane, covariance);
    planes.map.reclassify(graph, views[i].plane, planes.frame);
    if (planes.map.find(views[i].plane)->observations.size() == 1) planes.map.set_storey(views[i].plane, storey);
    result.seen.insert(views[i].plane);
    result.planes[views[i].index] = views[i].plane;
  }
  return result;
}

}  // namespace sgraph
