#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/localisation/localiser.hpp"
#include "sgraph_slam/core/localisation/map_tracker.hpp"
#include "sgraph_slam/core/localisation/taken_map.hpp"
#include "sgraph_slam/core/mapping/back_end.hpp"

namespace sgraph {

enum class MapMode {
  extend,    ///< "continue": a further session in the same graph
  localize,  ///< the map stays as it is
};

/// How a session takes up a map.
struct SessionStart {
  std::shared_ptr<const TakenMap> map;  ///< null: it begins a map of its own
  MapMode mode = MapMode::extend;
  std::optional<Pose> near;  ///< T_map_base of the first keyframe, roughly; nothing: it is searched for
};

/// A start pose from four numbers "x y z yaw" [m, rad]. Throws std::runtime_error.
Pose parse_start_pose(const std::string& text);

/// A start from words: `mode` "continue" or "localize"; `start` "search", "first" (where the map's first session began) or "x y z yaw". Throws
/// std::runtime_error, StoreError.
SessionStart make_start(const std::string& path, const std::string& mode, const std::string& start);

/// A session of mapping: the back end of a new map, or of one that is taken up as soon as it is known where the robot is in it. Until then the
/// session is mapped by itself; then all of its keyframes enter the map. One caller at a time.
class MappingSession {
 public:
  /// As for BackEnd. `start`: what to take up.
  MappingSession(const MappingParams& params, const Pose& T_base_lidar, std::shared_ptr<KeyframeClouds> clouds, SessionStart start = {});
  ~MappingSession();

  /// As for BackEnd.
  GraphSnapshotPtr process(const Keyframe& keyframe, const PlaneSegments& segments);
  GraphSnapshotPtr optimize();
  [[nodiscard]] GraphSnapshotPtr snapshot() const;
  [[nodiscard]] const DecisionLog& decisions() const;
  [[nodiscard]] const std::vector<std::string>& failures() const;
  [[nodiscard]] const std::map<std::string, double>& steps() const;  ///< none while localising

  /// Shows the map as it grows: the one taken up once it is, before that nothing. A map of its own that never found its place is shown at the end.
  void observe(MapObserver* observer);

  /// Poses of the session so far as a snapshot of its keyframes alone, for its trajectory.
  [[nodiscard]] GraphSnapshotPtr travelled() const;

  /// What is known of the place in the map; nothing when none was to be taken up.
  [[nodiscard]] std::optional<Localisation> localisation() const;
  /// Whether poses are in the frame of the map that was asked for, or there is none.
  [[nodiscard]] bool is_placed() const { return !start_.map || placed_; }
  /// Searches again from the next keyframe on, near a pose (T_map_base) when one is given.
  void search_again(const std::optional<Pose>& near);

 private:
  void wait_with(LocatedKeyframe seen);
  void place(Localisation found);  // a copy: the search that gave it ends
  GraphSnapshotPtr track(const LocatedKeyframe& seen);

  MappingParams params_;
  Pose T_base_lidar_;
  std::shared_ptr<KeyframeClouds> clouds_;
  SessionStart start_;
  MapObserver* observer_ = nullptr;

  std::unique_ptr<BackEnd> back_end_;
  std::unique_ptr<Localiser> localiser_;
  std::unique_ptr<MapTracker> tracker_;
  std::vector<LocatedKeyframe> before_;            // keyframes until the place was known, without their clouds
  std::shared_ptr<KeyframeClouds> before_clouds_;  // those: a search may last for hours, and a building's clouds don't fit into memory
  std::optional<Localisation> found_;
  bool placed_ = false;
  KeyframeId first_{0};  // keyframe of the back end's map that this session began with

  GraphSnapshotPtr snapshot_;  // when localising: the map, with this session's T_map_odom
  GraphSnapshot travelled_;    // when localising: this session's keyframes
  DecisionLog log_;            // when localising
};

}  // namespace sgraph
