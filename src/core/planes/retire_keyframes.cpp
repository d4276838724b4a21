#include "sgraph_slam/core/planes/retire_keyframes.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include <Eigen/LU>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/planes/moved_covariance.hpp"

namespace sgraph {
namespace {

constexpr double spot = 0.5;            // from no further apart a wall five metres away is seen within 6 degrees of the same direction [m]
constexpr std::size_t last_visits = 4;  // of retired keyframes at a spot, whose clouds stay
constexpr double as_large = 0.9;        // a view shows the same part of a plane when they overlap and it is at least this much of the other's area

// A view of a plane, its outline in the map.
struct View {
  FactorId factor;
  PlaneId plane;
  Outline outline;
  double area;
};

// The views of each keyframe that is asked for, by plane. Found by the keyframe's factors: what it costs grows with what the keyframe sees, not with
// the map.
class Views {
 public:
  Views(const Graph& graph, const PlaneMap& planes) : graph_(graph), planes_(planes) {}

  const std::vector<View>& of(KeyframeId id) {
    const auto [entry, fresh] = views_.try_emplace(id);
    if (!fresh) return entry->second;
    std::set<PlaneId> seen;
    for (const FactorId factor : graph_.factors_of(id)) {
      const FactorData& data = graph_.find(factor)->data;
      if (!is_view(data)) continue;
      for (const VariableId& variable : blocks(data)) {
        if (const auto* plane = std::get_if<PlaneId>(&variable)) seen.insert(*plane);
      }
    }
    const Pose& T_map_base = *graph_.find(id);
    for (const PlaneId plane : seen) {
      const PlaneRecord* record = planes_.find(plane);
      if (record == nullptr) continue;
      const auto [first, last] = record->views_of(id);
      for (auto view = first; view != last; ++view)
        entry->second.push_back({view->factor, plane, moved_outline(T_map_base, view->outline_base), outline_area(view->outline_base)});
    }
    return entry->second;
  }

  /// The keyframe's views have changed.
  void forget(KeyframeId id) { views_.erase(id); }

 private:
  const Graph& graph_;
  const PlaneMap& planes_;
  std::map<KeyframeId, std::vector<View>> views_;
};

bool shows(const Graph& graph, const std::vector<View>& views, const View& wanted) {
  return std::any_of(views.begin(), views.end(), [&](const View& view) {
    return view.plane == wanted.plane && view.area >= as_large * wanted.area &&
           outline_distance(*graph.find(view.plane), view.outline, wanted.outline) == 0;
  });
}

// What joins a keyframe to others.
struct Joints {
  std::vector<FactorId> before;  // odometry
  std::vector<FactorId> after;
  bool held_by_others = false;  // a loop, a ride, or a keyframe that was retired beside it
  bool retired = false;
};

Joints joints_of(const Graph& graph, KeyframeId id) {
  Joints joints;
  for (const FactorId factor : graph.factors_of(id)) {
    const auto* between = std::get_if<Se3Between>(&graph.find(factor)->data);
    if (between == nullptr) continue;
    if (between->source == Se3Between::Source::odometry) {
      (between->to == id ? joints.before : joints.after).push_back(factor);
    } else if (between->source == Se3Between::Source::retired && between->to == id) {
      joints.retired = true;
    } else {
      joints.held_by_others = true;
    }
  }
  return joints;
}

// One motion after the other.
Se3Between joined(const Se3Between& a, const Se3Between& b) {
  const Matrix6 turn = se3_adjoint(b.T_from_to.inverse());
  const Matrix6 covariance = turn * a.weight.information().inverse() * turn.transpose() + b.weight.information().inverse();
  return {a.from, b.to, a.T_from_to * b.T_from_to, SqrtInformation<6>::from_covariance(covariance, Vector6::Constant(1e-6)), a.source};
}

// The view as keyframe `to` would have it. What is uncertain of the pose between the two, millimetres, is far less than a view's own error.
FactorData seen_from(const Graph& graph, KeyframeId to, const FactorData& data) {
  if (const auto* points = std::get_if<PosePlanePoints>(&data)) {
    const Pose T_id_to = (*graph.find(points->keyframe) * points->T_base_lidar).inverse() * *graph.find(to) * points->T_base_lidar;
    // Planes in the other LiDAR's frame: the normal turns, and what the distance changes by goes with the normal.
    Eigen::Matrix4d plane_id_to = Eigen::Matrix4d::Identity();
    plane_id_to.topLeftCorner<3, 3>() = T_id_to.matrix();
    plane_id_to.bottomLeftCorner<1, 3>() = -T_id_to.translation.transpose() * T_id_to.matrix();
    return PosePlanePoints{to, points->plane, points->points * plane_id_to, points->T_base_lidar};
  }
  const auto& fitted = std::get<PosePlane>(data);
  const Pose T_to_id = (*graph.find(to) * fitted.T_base_lidar).inverse() * *graph.find(fitted.keyframe) * fitted.T_base_lidar;
  const Plane measured = T_to_id * fitted.measured;
  const Eigen::Matrix3d covariance = moved_covariance(T_to_id, fitted.measured, measured, fitted.weight.information().inverse());
  return PosePlane{to, fitted.plane, measured, fitted.T_base_lidar, SqrtInformation<3>::from_covariance(covariance, Eigen::Vector3d::Constant(1e-6))};
}

// What becomes of a keyframe's views.
struct Successor {
  KeyframeId keyframe;
  std::vector<FactorId> taken_over;
};

// A view that half of `enough` others show goes, as does one that the successor shows.
std::optional<Successor> successor_of(const Graph& graph, Views& views, KeyframeId id, const std::vector<KeyframeId>& at_spot, std::size_t enough) {
  const std::vector<View>& own = views.of(id);
  std::map<KeyframeId, std::size_t> shown_by;
  std::vector<const View*> rare;
  for (const View& view : own) {
    std::size_t count = 0;
    for (const KeyframeId other : at_spot) {
      if (!shows(graph, views.of(other), view)) continue;
      ++count;
      ++shown_by[other];
    }
    if (2 * count < enough) rare.push_back(&view);
  }
  if (shown_by.empty() || 2 * rare.size() > own.size()) return std::nullopt;
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  Successor found{std::max_element(shown_by.begin(), shown_by.end(), fewer)->first, {}};
  for (const View* view : rare) {
    if (!shows(graph, views.of(found.keyframe), *view)) found.taken_over.push_back(view->factor);
  }
  return found;
}

std::vector<KeyframeId> near(const Graph& graph, const std::vector<KeyframeId>& ids, const Eigen::Vector3d& here) {
  std::vector<KeyframeId> found;
  for (const KeyframeId id : ids) {
    if ((graph.find(id)->translation - here).squaredNorm() <= spot * spot) found.push_back(id);
  }
  return found;
}

bool retire(Committer& committer, PlaneLayer& planes, Views& views, KeyframeId id, const Joints& joints, const std::vector<KeyframeId>& at_spot) {
  const Graph& graph = committer.graph;
  const auto enough = static_cast<std::size_t>(planes.params.factors.spot_keyframes);
  const std::optional<Successor> successor = successor_of(graph, views, id, at_spot, enough);
  if (!successor) return false;
  Transaction edit;
  edit.reason = "retire keyframe/" + std::to_string(id.value);
  for (const View& view : views.of(id)) edit.remove_factors.push_back(view.factor);
  for (const FactorId factor : successor->taken_over) {
    const Factor& view = *graph.find(factor);
    add_factor(edit, seen_from(graph, successor->keyframe, view.data), view.loss);
  }
  edit.remove_factors.insert(edit.remove_factors.end(), {joints.before.front(), joints.after.front()});
  add_factor(edit,
             joined(std::get<Se3Between>(graph.find(joints.before.front())->data), std::get<Se3Between>(graph.find(joints.after.front())->data)));
  add_factor(edit, Se3Between{successor->keyframe, id, graph.find(successor->keyframe)->inverse() * *graph.find(id),
                              SqrtInformation<6>::from_std_dev(retired_sigma(planes.params.factors)), Se3Between::Source::retired});
  const Applied applied = committer.commit(edit);
  if (!applied.ok()) return false;
  std::map<FactorId, FactorId> now;
  for (std::size_t i = 0; i < successor->taken_over.size(); ++i) now[successor->taken_over[i]] = applied.factors[i];
  planes.map.retire(graph, id, successor->keyframe, now);
  views.forget(id);
  views.forget(successor->keyframe);
  return true;
}

}  // namespace

Vector6 retired_sigma(const FactorParams& params) {
  Vector6 sigma;
  sigma << Eigen::Vector3d::Constant(params.keyframe_floor_angle), Eigen::Vector3d::Constant(params.keyframe_floor_distance);
  return sigma;
}

std::vector<KeyframeId> retire_keyframes(Committer& committer, PlaneLayer& planes, KeyframeId first, KeyframeId end) {
  const auto enough = static_cast<std::size_t>(planes.params.factors.spot_keyframes);
  const KeyframeId begin = std::max(planes.may_retire, first);
  if (enough == 0 || !(begin < end)) return {};
  planes.may_retire = end;
  const Graph& graph = committer.graph;
  std::vector<KeyframeId> kept;
  for (auto keyframe = graph.keyframes().lower_bound(first); keyframe != graph.keyframes().end() && keyframe->first < begin; ++keyframe) {
    if (!joints_of(graph, keyframe->first).retired) kept.push_back(keyframe->first);
  }
  Views views(graph, planes.map);
  std::vector<KeyframeId> retired;
  for (auto keyframe = graph.keyframes().lower_bound(begin); keyframe != graph.keyframes().end() && keyframe->first < end; ++keyframe) {
    const auto& [id, T_map_base] = *keyframe;
    const std::vector<KeyframeId> at_spot = near(graph, kept, T_map_base.translation);
    const Joints joints = joints_of(graph, id);
    const bool may = at_spot.size() >= enough && !joints.held_by_others && joints.before.size() == 1 && joints.after.size() == 1;
    if (may && retire(committer, planes, views, id, joints, at_spot)) {
      retired.push_back(id);
    } else {
      kept.push_back(id);
    }
  }
  return retired;
}

std::vector<KeyframeId> clouds_to_let_go(const Graph& graph, std::set<KeyframeId>& with_clouds, const std::vector<KeyframeId>& newly) {
  std::vector<KeyframeId> gone;
  for (const KeyframeId id : newly) {
    with_clouds.insert(id);
    std::vector<KeyframeId> here = near(graph, {with_clouds.begin(), with_clouds.end()}, graph.find(id)->translation);
    const auto most = static_cast<std::ptrdiff_t>(last_visits);
    for (auto old = here.begin(); here.end() - old > most; ++old) {
      with_clouds.erase(*old);
      gone.push_back(*old);
    }
  }
  return gone;
}

}  // namespace sgraph
