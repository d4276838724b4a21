#include "sgraph_slam/core/mapping/back_end.hpp"

#include <exception>
#include <optional>
#include <utility>

#include "map_builder.hpp"
#include "sgraph_slam/core/mapping/make_snapshot.hpp"
#include "sgraph_slam/core/mapping/map_state.hpp"

namespace sgraph {

class BackEnd::Implementation {
 public:
  Implementation(const MappingParams& params, const Pose& T_base_lidar, std::shared_ptr<KeyframeClouds> clouds)
      : state_(params, T_base_lidar, std::move(clouds)), snapshot_(std::make_shared<GraphSnapshot>()) {}

  void go_on_with(KeptMap map, const Pose& T_map_odom, const Matrix6& covariance) {
    builder_.go_on_with(std::move(map), T_map_odom, covariance);
    checkpoint();
    publish(false);
  }

  GraphSnapshotPtr process(const Keyframe& given, const PlaneSegments& segments) {
    builder_.clock().start();
    if (state_.session.first == 0) return map(given, segments);
    std::optional<Keyframe> keyframe;
    const std::string failure = failure_of([&] { keyframe = of_map(given); });
    if (keyframe) return map(*keyframe, segments);
    report(given.id, failure, "left out");
    return snapshot_;
  }

  GraphSnapshotPtr map(const Keyframe& keyframe, const PlaneSegments& segments) {
    std::optional<MappingInput> input;
    std::string failure = failure_of([&] {
      input = MappingInput{without_cloud(keyframe), kept(keyframe), segments, true};
      builder_.clock().book("cloud");
      work_on(*input);
    });
    if (failure.empty()) return shown(&keyframe);
    restore();
    if (input) {
      report(keyframe.id, failure, "kept without its planes: it still joins those before and after it");
      input->planes = false;
      failure = failure_of([&] { work_on(*input); });
      if (failure.empty()) return shown(&keyframe);
      restore();
    }
    report(keyframe.id, failure, "left out");
    return snapshot_;
  }

  GraphSnapshotPtr optimize() {
    // Asked twice (at the end of a recording, and again to save it) the map stays as it is.
    if (state_.keyframes.empty() || state_.optimized) return snapshot_;
    builder_.clock().start();
    const std::string failure = failure_of([this] {
      builder_.optimize();
      publish(true);
    });
    if (!failure.empty()) {
      restore();
      report(builder_.newest(), failure, "not optimised");
      publish(true);  // the last good state, whole: what can be saved
    }
    checkpoint();
    return shown(nullptr);
  }

  void observe(MapObserver* observer) { observer_ = observer; }
  [[nodiscard]] GraphSnapshotPtr snapshot() const { return snapshot_; }
  [[nodiscard]] const DecisionLog& decisions() const { return state_.log; }
  [[nodiscard]] const std::vector<std::string>& failures() const { return failures_; }
  [[nodiscard]] const std::map<std::string, double>& steps() { return builder_.clock().milliseconds(); }

 private:
  GraphSnapshotPtr shown(const Keyframe* added) {
    const std::vector<KeyframeId> gone = std::exchange(state_.clouds_let_go, {});
    if (state_.clouds) {
      for (const KeyframeId id : gone) state_.clouds->put(id, nullptr);
    }
    if (observer_ == nullptr) return snapshot_;
    const std::string failure = failure_of([&] { observer_->changed({state_.graph, state_.planes.map, state_.log, *snapshot_, added, gone}); });
    if (!failure.empty()) failures_.push_back("the map was not shown: " + failure);
    builder_.clock().book("store");
    return snapshot_;
  }

  // The session's keyframe as one of the whole map.
  [[nodiscard]] Keyframe of_map(Keyframe keyframe) const {
    const Session& session = state_.session;
    if (state_.keyframes.rbegin()->first.value < session.first) {  // it joins the session before by where it was found, not by odometry
      keyframe.covariance = session.covariance;
      keyframe.degenerate.clear();
      keyframe.measured.reset();
      keyframe.ride.reset();
    }
    keyframe.id.value += session.first;
    keyframe.T_odom_base = session.T_odom_own * keyframe.T_odom_base;
    for (StampedPose& scan : keyframe.scans) scan.pose = session.T_odom_own * scan.pose;
    return keyframe;
  }

  static Keyframe without_cloud(Keyframe keyframe) {
    keyframe.cloud.reset();
    return keyframe;
  }

  [[nodiscard]] KeyframeCloud kept(const Keyframe& keyframe) const {
    if (!state_.clouds || !keyframe.cloud) return keyframe.cloud;
    state_.clouds->put(keyframe.id, keyframe.cloud);
    return {state_.clouds, keyframe.id};
  }

  // What a step throws, in words; empty when it doesn't.
  template <class Step>
  static std::string failure_of(const Step& step) {
    try {
      step();
      return {};
    } catch (const std::exception& error) {
      return *error.what() == 0 ? "exception without words" : error.what();
    } catch (...) {
      return "unknown exception";
    }
  }

  void report(KeyframeId id, const std::string& failure, const char* what_now) {
    const std::string what = "keyframe/" + std::to_string(id.value);
    const std::string reason = "a step of the mapping failed (" + failure + "): back to the state before it, " + what_now;
    reports_.push_back({id, false, what, reason});
    state_.log.push_back(reports_.back());
    failures_.push_back(what + ": " + reason);
  }

  // A step that fails half-way would leave graph, plane map and layer in disagreement. So a whole state is copied now and then, as rarely as the
  // whole graph is solved, and what came since is kept: from these the last good state is made again, to the last bit, when it is needed.
  void work_on(const MappingInput& input) {
    if (!builder_.add(input)) return;
    publish(false);
    since_.push_back(input);
    if (since_.size() >= static_cast<std::size_t>(builder_.due()))
      failure_of([this] { checkpoint(); });  // without it the old one and what came since still do
  }

  void checkpoint() {
    good_ = std::make_unique<const MapState>(state_);
    since_.clear();
    reports_.clear();
    builder_.clock().book("copy");
  }

  [[nodiscard]] MapState last_good() const { return good_ ? *good_ : MapState(state_.params, state_.planes.T_base_lidar, state_.clouds); }

  void restore() {
    state_ = last_good();
    const std::string failure = failure_of([this] {
      for (const MappingInput& input : since_) builder_.add(input);
    });
    if (!failure.empty()) {  // it went well before: the machine is short of something
      state_ = last_good();
      since_.clear();
      failures_.push_back("the keyframes since the last copy of the map are lost: " + failure);
    }
    state_.log.insert(state_.log.end(), reports_.begin(), reports_.end());
  }

  void publish(bool whole) {
    snapshot_ = make_snapshot(state_, snapshot_->version + 1, builder_.last_solve(), whole);
    builder_.clock().book("snapshot");
  }

  MapState state_;
  MapObserver* observer_ = nullptr;
  MapBuilder builder_{state_};
  GraphSnapshotPtr snapshot_;

  std::unique_ptr<const MapState> good_;  // a state to come back to; none: the empty one
  std::vector<MappingInput> since_;       // what came after it
  DecisionLog reports_;                   // of failures after it
  std::vector<std::string> failures_;
};

BackEnd::BackEnd(const MappingParams& params, const Pose& T_base_lidar, std::shared_ptr<KeyframeClouds> clouds)
    : implementation_(std::make_unique<Implementation>(params, T_base_lidar, std::move(clouds))) {}
BackEnd::~BackEnd() = default;

void BackEnd::go_on_with(KeptMap map, const Pose& T_map_odom, const Matrix6& covariance) {
  implementation_->go_on_with(std::move(map), T_map_odom, covariance);
}
void BackEnd::observe(MapObserver* observer) { implementation_->observe(observer); }
GraphSnapshotPtr BackEnd::process(const Keyframe& keyframe, const PlaneSegments& segments) { return implementation_->process(keyframe, segments); }
GraphSnapshotPtr BackEnd::optimize() { return implementation_->optimize(); }
GraphSnapshotPtr BackEnd::snapshot() const { return implementation_->snapshot(); }
const DecisionLog& BackEnd::decisions() const { return implementation_->decisions(); }
const std::vector<std::string>& BackEnd::failures() const { return implementation_->failures(); }
const std::map<std::string, double>& BackEnd::steps() const { return implementation_->steps(); }

}  // namespace sgraph
