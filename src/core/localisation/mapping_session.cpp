#include "sgraph_slam/core/localisation/mapping_session.hpp"

#include <Eigen/Geometry>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "sgraph_slam/core/io/temporary_clouds.hpp"

namespace sgraph {
namespace {

constexpr double start_sigma_angle = 0.01;  // of a place that was found [rad]
constexpr double start_sigma = 0.05;        // [m]

Matrix6 start_covariance() {
  Vector6 sigma;
  sigma << Eigen::Vector3d::Constant(start_sigma_angle), Eigen::Vector3d::Constant(start_sigma);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

Pose parse_start_pose(const std::string& text) {
  std::istringstream in(text);
  Eigen::Vector4d v;
  std::string rest;
  if (!(in >> v[0] >> v[1] >> v[2] >> v[3]) || in >> rest || !v.allFinite()) {
    throw std::runtime_error("a start pose is four numbers \"x y z yaw\" (metres, radians), not '" + text + "'");
  }
  return {Eigen::Quaterniond(Eigen::AngleAxisd(v[3], Eigen::Vector3d::UnitZ())), v.head<3>()};
}

SessionStart make_start(const std::string& path, const std::string& mode, const std::string& start) {
  SessionStart result;
  if (mode != "continue" && mode != "localize") throw std::runtime_error("a map's mode is continue or localize, not '" + mode + "'");
  result.mode = mode == "localize" ? MapMode::localize : MapMode::extend;
  if (start != "search" && start != "first") result.near = parse_start_pose(start);
  result.map = take_map(path);
  if (start == "first") result.near = result.map->reference->first_pose();
  return result;
}

MappingSession::MappingSession(const MappingParams& params, const Pose& T_base_lidar, std::shared_ptr<KeyframeClouds> clouds, SessionStart start)
    : params_(params),
      T_base_lidar_(T_base_lidar),
      clouds_(std::move(clouds)),
      start_(std::move(start)),
      back_end_(std::make_unique<BackEnd>(params, T_base_lidar, clouds_)) {
  if (start_.map) localiser_ = std::make_unique<Localiser>(start_.map->reference, T_base_lidar_, start_.near);
}

MappingSession::~MappingSession() = default;

GraphSnapshotPtr MappingSession::process(const Keyframe& keyframe, const PlaneSegments& segments) {
  if (!start_.map) return back_end_->process(keyframe, segments);
  LocatedKeyframe seen{keyframe, segments};
  if (localiser_) wait_with(seen);
  seen.keyframe.cloud.reset();  // what follows compares planes
  if (localiser_) {
    const Localisation& answer = localiser_->add(seen);
    if (answer.result == LocalisationResult::found) {
      place(answer);
      return snapshot();
    }
    if (tracker_) return track(seen);  // lost: it goes on from where it believed to be
    return back_end_->process(keyframe, segments);
  }
  return tracker_ ? track(seen) : back_end_->process(keyframe, segments);
}

void MappingSession::wait_with(LocatedKeyframe seen) {
  if (start_.mode == MapMode::localize) {  // nothing is mapped
    seen.keyframe.cloud.reset();
  } else if (clouds_ && seen.keyframe.cloud) {
    if (!before_clouds_) before_clouds_ = std::make_shared<TemporaryClouds>();
    before_clouds_->put(seen.keyframe.id, seen.keyframe.cloud);
    seen.keyframe.cloud.reset();
  }
  before_.push_back(std::move(seen));
}

void MappingSession::place(Localisation found) {
  found_ = std::move(found);
  placed_ = true;
  localiser_.reset();
  std::vector<LocatedKeyframe> all;
  all.swap(before_);
  log_.push_back({all.back().keyframe.id, true, "place in " + start_.map->path, found_->reason});
  if (start_.mode == MapMode::localize) {
    tracker_ = std::make_unique<MapTracker>(start_.map->reference, MapTrackerParams{params_.factors, params_.association}, T_base_lidar_,
                                            found_->T_map_odom, start_covariance());
    for (const LocatedKeyframe& seen : all) track(seen);
    return;
  }
  // Clouds of the session go where those of its own map went: the ids are new.
  back_end_ = std::make_unique<BackEnd>(params_, T_base_lidar_, clouds_);
  KeptMap kept = kept_map(*start_.map);
  first_ = {kept.keyframes.rbegin()->first.value + 1};
  back_end_->go_on_with(std::move(kept), found_->T_map_odom, start_covariance());
  back_end_->observe(observer_);
  for (LocatedKeyframe& seen : all) {
    if (before_clouds_ && !seen.keyframe.cloud) seen.keyframe.cloud = before_clouds_->get(seen.keyframe.id);
    back_end_->process(seen.keyframe, seen.segments);
    seen.keyframe.cloud.reset();
  }
  before_clouds_.reset();
}

GraphSnapshotPtr MappingSession::track(const LocatedKeyframe& seen) {
  const Keyframe& keyframe = seen.keyframe;
  SceneKeyframe& scene = travelled_.keyframes[keyframe.id];
  scene.id = keyframe.id;
  scene.stamp = keyframe.stamp;
  scene.T_map_base = tracker_->process(seen);
  scene.T_odom_base = keyframe.T_odom_base;
  scene.scans = keyframe.scans;
  travelled_.T_map_odom = tracker_->T_map_odom();
  auto snapshot = std::make_shared<GraphSnapshot>(*start_.map->snapshot);
  snapshot->version = (snapshot_ ? snapshot_->version : start_.map->snapshot->version) + 1;
  snapshot->T_map_odom = tracker_->T_map_odom();
  snapshot->last_solve = {};
  snapshot_ = snapshot;
  if (tracker_->is_lost() && !localiser_) {
    log_.push_back({keyframe.id, false, "place in " + start_.map->path, "lost: what is seen contradicts the map"});
    search_again(std::nullopt);
  }
  return snapshot_;
}

void MappingSession::search_again(const std::optional<Pose>& near) {
  if (!start_.map || (placed_ && start_.mode == MapMode::extend)) return;
  localiser_ = std::make_unique<Localiser>(start_.map->reference, T_base_lidar_, near);
  if (tracker_) before_.clear();  // these have their poses
}

GraphSnapshotPtr MappingSession::optimize() {
  if (tracker_) return snapshot_;
  if (start_.map && !placed_) back_end_->observe(nullptr);
  return back_end_->optimize();
}

GraphSnapshotPtr MappingSession::snapshot() const { return tracker_ ? snapshot_ : back_end_->snapshot(); }
const DecisionLog& MappingSession::decisions() const { return tracker_ ? log_ : back_end_->decisions(); }
const std::vector<std::string>& MappingSession::failures() const { return back_end_->failures(); }
const std::map<std::string, double>& MappingSession::steps() const {
  static const std::map<std::string, double> none;
  return tracker_ ? none : back_end_->steps();
}

void MappingSession::observe(MapObserver* observer) {
  observer_ = observer;
  if (is_placed() && !tracker_) back_end_->observe(observer);
}

GraphSnapshotPtr MappingSession::travelled() const {
  if (tracker_) return std::make_shared<const GraphSnapshot>(travelled_);
  if (first_.value == 0) return back_end_->snapshot();
  const GraphSnapshotPtr all = back_end_->snapshot();
  auto own = std::make_shared<GraphSnapshot>();
  own->T_map_odom = all->T_map_odom;
  own->keyframes.insert(all->keyframes.lower_bound(first_), all->keyframes.end());
  return own;
}

std::optional<Localisation> MappingSession::localisation() const {
  if (found_) return found_;
  if (localiser_) return localiser_->answer();
  return std::nullopt;
}

}  // namespace sgraph
