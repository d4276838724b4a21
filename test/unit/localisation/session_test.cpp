#include "sgraph_slam/core/localisation/mapping_session.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/localisation/changes.hpp"
#include "sgraph_slam/core/localisation/merge_maps.hpp"
#include "sgraph_slam/core/pipeline/run.hpp"
#include "sgraph_slam/core/store/map_recording.hpp"
#include "support/mapped_building.hpp"

namespace sgraph {
namespace {

using Way = std::vector<Eigen::Vector2d>;

class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "session-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~Folder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + '/' + name; }

 private:
  std::string path_;
};

// Two rooms and a corridor.
MappedBuilding flat() {
  MappedBuilding building;
  building.add_room(0, 5.8, 16, 7.85, {{{4.0, 5.0}, {12.0, 13.0}}, {}, {}, {}});
  building.add_room(0, 0, 9.05, 5.65, {{}, {}, {{4.05, 5.05}}, {}});
  building.add_room(9.2, 0, 16, 5.65, {{}, {}, {{3.0, 4.0}}, {}});
  return building;
}

Way flat_way() {
  return {{2, 2},    {7, 2},      {7, 4},   {4.5, 4.5}, {4.5, 6.8}, {12.5, 6.8}, {12.5, 4}, {14, 2}, {11, 2},
          {12.5, 4}, {12.5, 6.8}, {2, 6.8}, {4.5, 6.8}, {4.5, 4},   {2, 2},      {4.5, 3},  {7, 2}};
}

StoredSession session() {
  StoredSession session;
  session.source = "test";
  session.T_base_lidar = MappedBuilding::T_base_lidar();
  return session;
}

std::vector<SeenKeyframe> walked(const Way& way, unsigned seed) { return flat().walk(way, 0.6, 0.3, {}, seed); }

void write_map_of(const std::vector<SeenKeyframe>& walk, const std::string& path) {
  MapRecording recording(path, session());
  MappingSession mapping({}, MappedBuilding::T_base_lidar(), nullptr);
  mapping.observe(&recording.observer());
  for (const SeenKeyframe& seen : walk) mapping.process(seen.keyframe, seen.segments);
  mapping.optimize();
  recording.finish();
}

// Ids that begin anew, in an odometry that begins anew: as after switching the robot off and on.
std::vector<SeenKeyframe> anew(std::vector<SeenKeyframe> walk) {
  const Pose T_new_old = walk.front().keyframe.T_odom_base.inverse();
  const std::int64_t first = walk.front().keyframe.id.value;
  for (SeenKeyframe& seen : walk) {
    seen.keyframe.id.value -= first;
    seen.keyframe.T_odom_base = T_new_old * seen.keyframe.T_odom_base;
    for (StampedPose& scan : seen.keyframe.scans) scan.pose = T_new_old * scan.pose;
  }
  return walk;
}

TEST(TakenMap, IsTheGraphThatWasWritten) {
  const Folder folder;
  write_map_of(walked(flat_way(), 3), folder.file("map.sgmap"));
  const auto taken = take_map(folder.file("map.sgmap"));
  const KeptMap kept = kept_map(*taken);
  EXPECT_EQ(kept.keyframes.size(), taken->stored.keyframes.size());
  EXPECT_EQ(kept.planes.size(), kept.graph.planes().size());
  for (const auto& [id, pose] : kept.graph.keyframes()) EXPECT_EQ(pose.translation, taken->stored.poses.at(id).translation);
  std::size_t views = 0;
  for (const auto& [id, record] : kept.planes) views += record.observations.size();
  EXPECT_EQ(views, taken->stored.views.size());
}

// A recording cut in two, the second half going on with the first one's map, is the uninterrupted one.
TEST(MappingSession, ACutRecordingEndsAsTheUninterruptedOne) {
  const Folder folder;
  const auto whole = walked(flat_way(), 4);
  BackEnd uninterrupted({}, MappedBuilding::T_base_lidar());
  for (const SeenKeyframe& seen : whole) uninterrupted.process(seen.keyframe, seen.segments);
  const GraphSnapshotPtr expected = uninterrupted.optimize();

  const auto middle = whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2);
  write_map_of({whole.begin(), middle}, folder.file("map.sgmap"));
  const std::vector<SeenKeyframe> second = anew({middle, whole.end()});
  const auto taken = take_map(folder.file("map.sgmap"));
  MapRecording recording(folder.file("both.sgmap"), session(), taken->path, taken->stored);
  MappingSession mapping({}, MappedBuilding::T_base_lidar(), nullptr, {taken, MapMode::extend, {}});
  mapping.observe(&recording.observer());
  for (const SeenKeyframe& seen : second) mapping.process(seen.keyframe, seen.segments);
  const GraphSnapshotPtr both = mapping.optimize();
  recording.finish();
  ASSERT_EQ(mapping.localisation()->result, LocalisationResult::found) << mapping.localisation()->reason;
  ASSERT_EQ(both->keyframes.size(), expected->keyframes.size());
  EXPECT_EQ(both->rooms.size(), expected->rooms.size());
  EXPECT_NEAR(static_cast<double>(both->planes.size()), static_cast<double>(expected->planes.size()), 2);
  double squares = 0;
  for (const auto& [id, keyframe] : expected->keyframes)
    squares += (both->keyframes.at(id).T_map_base.translation - keyframe.T_map_base.translation).squaredNorm();
  EXPECT_LT(std::sqrt(squares / static_cast<double>(expected->keyframes.size())), 0.001);
  // The session's trajectory is its own, in the map's frame, with what came before it was found.
  const Trajectory trajectory = corrected_trajectory(*mapping.travelled());
  std::size_t scans = 0;
  for (const SeenKeyframe& seen : second) scans += seen.keyframe.scans.size();
  EXPECT_EQ(trajectory.size(), scans);

  const StoredMap stored = read_map(folder.file("both.sgmap"), Clouds::none);
  EXPECT_EQ(stored.sessions.size(), 2U);
  EXPECT_TRUE(check_map(folder.file("both.sgmap")).empty());
  EXPECT_EQ(stored.keyframes.size(), both->keyframes.size());
  for (const auto& [id, keyframe] : both->keyframes) EXPECT_EQ(stored.poses.at(id).translation, keyframe.T_map_base.translation);
  EXPECT_EQ(read_map(folder.file("map.sgmap"), Clouds::none).sessions.size(), 1U);
}

TEST(MappingSession, LocalisesInAMapThatStaysAsItIs) {
  const Folder folder;
  const auto mapped = walked(flat_way(), 5);
  write_map_of(mapped, folder.file("map.sgmap"));
  const auto taken = take_map(folder.file("map.sgmap"));
  const Pose T_world_map = mapped.front().T_world_base * taken->stored.poses.begin()->second.inverse();
  const Way other{{14, 4}, {12.5, 3}, {12.5, 6.8}, {3, 6.8}, {4.5, 6.8}, {4.5, 3}, {7, 3}, {2, 4}, {4.5, 4}, {4.5, 6.8}, {14, 6.8}};
  BuildingNoise drifting;
  drifting.odometry_scale = 0.01;
  drifting.odometry_heading = 0.002;
  const auto second = flat().walk(other, 0.6, -2.0, drifting, 6);
  MappingSession mapping({}, MappedBuilding::T_base_lidar(), nullptr, {taken, MapMode::localize, {}});
  for (const SeenKeyframe& seen : second) mapping.process(seen.keyframe, seen.segments);
  const GraphSnapshotPtr snapshot = mapping.optimize();
  ASSERT_EQ(mapping.localisation()->result, LocalisationResult::found) << mapping.localisation()->reason;
  EXPECT_EQ(snapshot->keyframes.size(), taken->snapshot->keyframes.size());
  const GraphSnapshotPtr travelled = mapping.travelled();
  ASSERT_EQ(travelled->keyframes.size(), second.size());
  double squares = 0;
  for (const SeenKeyframe& seen : second) {
    const Pose error = seen.T_world_base.inverse() * T_world_map * travelled->keyframes.at(seen.keyframe.id).T_map_base;
    squares += error.translation.squaredNorm();
    EXPECT_LT(error.translation.norm(), 0.08) << seen.keyframe.id.value;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(second.size())), 0.03);
}

TEST(MappingSession, AStartThatIsToldIsTakenUpAtOnce) {
  const Folder folder;
  const auto mapped = walked(flat_way(), 7);
  write_map_of(mapped, folder.file("map.sgmap"));
  const auto taken = take_map(folder.file("map.sgmap"));
  const Pose T_world_map = mapped.front().T_world_base * taken->stored.poses.begin()->second.inverse();
  const auto second = walked({{7, 3}, {2, 3}, {4.5, 4}}, 8);
  Pose near = T_world_map.inverse() * second.front().T_world_base;
  near.translation += Eigen::Vector3d(0.8, -0.6, 0.1);
  MappingSession mapping({}, MappedBuilding::T_base_lidar(), nullptr, {taken, MapMode::localize, near});
  for (const SeenKeyframe& seen : second) mapping.process(seen.keyframe, seen.segments);
  ASSERT_EQ(mapping.localisation()->result, LocalisationResult::found) << mapping.localisation()->reason;
  const Pose error = second.back().T_world_base.inverse() * T_world_map * mapping.travelled()->keyframes.rbegin()->second.T_map_base;
  EXPECT_LT(error.translation.norm(), 0.05);
}

TEST(MappingSession, AStrangeBuildingStaysAMapOfItsOwn) {
  const Folder folder;
  write_map_of(walked(flat_way(), 9), folder.file("map.sgmap"));
  const auto taken = take_map(folder.file("map.sgmap"));
  MappedBuilding other;
  other.add_room(0, 0, 7, 4.5, {{}, {}, {{3, 4}}, {}});
  other.add_room(0, 4.65, 13, 6.45, {{{3, 4}}, {}, {}, {}});
  MappingSession mapping({}, MappedBuilding::T_base_lidar(), nullptr, {taken, MapMode::extend, {}});
  const auto walk = other.walk({{2, 2}, {6, 2}, {3.5, 3.5}, {3.5, 5.5}, {11.5, 5.5}}, 0.6, 0, {}, 10);
  for (const SeenKeyframe& seen : walk) mapping.process(seen.keyframe, seen.segments);
  EXPECT_EQ(mapping.localisation()->result, LocalisationResult::not_found);
  EXPECT_EQ(mapping.optimize()->keyframes.size(), walk.size());
}

// Two robots' maps become one; taken out again, the first is what it was. Another building's is refused.
TEST(MergeMaps, JoinsTheSessionsOfOneBuildingOnly) {
  const Folder folder;
  write_map_of(walked(flat_way(), 11), folder.file("a.sgmap"));
  const Way other{{14, 4}, {12.5, 3}, {12.5, 6.8}, {3, 6.8}, {4.5, 6.8}, {4.5, 3}, {7, 3}, {2, 4}};
  write_map_of(flat().walk(other, 0.6, 1.7, {}, 12), folder.file("b.sgmap"));
  const StoredMap b = read_map(folder.file("b.sgmap"), Clouds::none);
  const Localisation place = add_session(b, 0, folder.file("a.sgmap"), folder.file("c.sgmap"), {}, {});
  EXPECT_EQ(place.result, LocalisationResult::found) << place.reason;
  EXPECT_TRUE(check_map(folder.file("c.sgmap")).empty());
  const StoredMap both = read_map(folder.file("c.sgmap"), Clouds::none);
  EXPECT_EQ(both.sessions.size(), 2U);
  EXPECT_EQ(both.keyframes.size(), b.keyframes.size() + read_map(folder.file("a.sgmap"), Clouds::none).keyframes.size());

  MappedBuilding stranger;
  stranger.add_room(0, 0, 7, 4.5, {{}, {}, {{3, 4}}, {}});
  stranger.add_room(0, 4.65, 13, 6.45, {{{3, 4}}, {}, {}, {}});
  write_map_of(stranger.walk({{2, 2}, {6, 2}, {3.5, 3.5}, {3.5, 5.5}, {11.5, 5.5}}, 0.6, 0, {}, 13), folder.file("s.sgmap"));
  const Localisation nowhere = add_session(read_map(folder.file("s.sgmap"), Clouds::none), 0, folder.file("a.sgmap"), folder.file("d.sgmap"), {}, {});
  EXPECT_EQ(nowhere.result, LocalisationResult::not_found) << nowhere.reason;
  EXPECT_EQ(read_map(folder.file("d.sgmap"), Clouds::none).sessions.size(), 1U);
}

// A wall that was built between two visits, and nothing else.
TEST(Changes, TellANewWall) {
  const Folder folder;
  write_map_of(walked(flat_way(), 14), folder.file("a.sgmap"));
  MappedBuilding rebuilt = flat();
  rebuilt.add_face({5.9, 0}, {5.9, 3});  // both faces of a wall across the first room
  rebuilt.add_face({6, 3}, {6, 0});
  write_map_of(
      rebuilt.walk({{14, 4}, {12.5, 3}, {12.5, 6.8}, {4.5, 6.8}, {4.5, 4}, {2, 2}, {4.5, 4}, {7.5, 4}, {7.5, 2}, {7.5, 4}, {4.5, 4}, {4.5, 2}}, 0.6,
                   0.2, {}, 15),
      folder.file("b.sgmap"));
  const Localisation place = add_session(read_map(folder.file("b.sgmap"), Clouds::none), 0, folder.file("a.sgmap"), folder.file("c.sgmap"), {}, {});
  ASSERT_EQ(place.result, LocalisationResult::found) << place.reason;
  const std::vector<MapChange> changes = changes_of(read_map(folder.file("c.sgmap"), Clouds::none), 1);
  ASSERT_GE(changes.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(changes[i].appeared);
    EXPECT_NEAR(changes[i].length, 3, 0.8);
  }
  for (std::size_t i = 2; i < changes.size(); ++i) EXPECT_LT(changes[i].length, 1.5);
}

TEST(StartPose, IsFourNumbers) {
  const Pose pose = parse_start_pose("1 -2 0.5 1.57");
  EXPECT_EQ(pose.translation, Eigen::Vector3d(1, -2, 0.5));
  EXPECT_NEAR((pose.rotation * Eigen::Vector3d::UnitX()).y(), 1, 1e-4);
  for (const char* text : {"", "1 2 3", "1 2 3 4 5", "a b c d", "1 2 3 nan"}) EXPECT_THROW(parse_start_pose(text), std::runtime_error) << text;
}

}  // namespace
}  // namespace sgraph
