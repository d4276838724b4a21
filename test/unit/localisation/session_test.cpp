#include "sgraph_slam/core/localisation/mapping_session.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/io/temporary_clouds.hpp"
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

GraphSnapshotPtr write_map_of(const std::vector<SeenKeyframe>& walk, const std::string& path, const MappingParams& params = {}) {
  MapRecording recording(path, session());
  MappingSession mapping(params, MappedBuilding::T_base_lidar(), nullptr);
  mapping.observe(&recording.observer());
  for (const SeenKeyframe& seen : walk) mapping.process(seen.keyframe, seen.segments);
  GraphSnapshotPtr last = mapping.optimize();
  recording.finish();
  return last;
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

std::string numbers(const KeyframeSet& keyframes) {
  std::string text;
  for (const KeyframeId id : keyframes) text += std::to_string(id.value) + ' ';
  return text;
}

// Keyframes that were retired, whose views others have taken over, still count as those that saw a plane: in the file, and in what is taken up
// from it.
TEST(TakenMap, KnowsWhichKeyframesSawAPlaneThoughTheyAreRetired) {
  const Folder folder;
  MappingParams params;
  params.factors.spot_keyframes = 2;
  Way way = flat_way();
  way.insert(way.end(), way.begin(), way.end());
  const GraphSnapshotPtr live = write_map_of(flat().walk(way, 1.2, 0.3, {}, 3), folder.file("map.sgmap"), params);
  const auto taken = take_map(folder.file("map.sgmap"));
  const KeptMap kept = kept_map(*taken);
  std::size_t retired = 0;
  ASSERT_EQ(taken->snapshot->planes.size(), live->planes.size());
  for (const auto& [id, plane] : live->planes) {
    EXPECT_EQ(numbers(taken->snapshot->planes.at(id).keyframes), numbers(plane.keyframes)) << "plane " << id.value;
    retired += kept.planes.at(id).retired.size();
  }
  EXPECT_GT(retired, 50U);

  BackEnd back_end(params, MappedBuilding::T_base_lidar());
  back_end.go_on_with(kept_map(*taken), Pose{}, Matrix6::Identity());
  for (const auto& [id, plane] : back_end.snapshot()->planes)
    EXPECT_EQ(numbers(plane.keyframes), numbers(live->planes.at(id).keyframes)) << "plane " << id.value;
}

// The search may last for hours, in a building that is not in the map: the clouds wait on the disk meanwhile, not in memory; once the place is known,
// all of them enter the map.
TEST(MappingSession, CloudsOfALongSearchAreNotInMemory) {
  const Folder folder;
  write_map_of(walked(flat_way(), 9), folder.file("map.sgmap"));
  for (const bool known : {false, true}) {
    const auto taken = take_map(folder.file("map.sgmap"));
    MappedBuilding other;
    other.add_room(0, 0, 7, 4.5, {{}, {}, {{3, 4}}, {}});
    other.add_room(0, 4.65, 13, 6.45, {{{3, 4}}, {}, {}, {}});
    MappingSession mapping({}, MappedBuilding::T_base_lidar(), std::make_shared<TemporaryClouds>("", 2), {taken, MapMode::extend, {}});
    const Way strange{{2, 2}, {6, 2}, {3.5, 3.5}, {3.5, 5.5}, {11.5, 5.5}, {3.5, 5.5}, {3.5, 3.5}, {2, 2}, {6, 2}};
    const auto walk = known ? walked(flat_way(), 10) : other.walk(strange, 0.6, 0, {}, 10);
    std::vector<std::weak_ptr<const Cloud>> clouds;
    for (const SeenKeyframe& seen : walk) {
      Keyframe keyframe = seen.keyframe;
      auto cloud = std::make_shared<Cloud>();
      cloud->points.resize(10 + static_cast<std::size_t>(keyframe.id.value));
      keyframe.cloud = cloud;
      clouds.push_back(keyframe.cloud);
      mapping.process(keyframe, seen.segments);
    }
    const auto in_memory = std::count_if(clouds.begin(), clouds.end(), [](const auto& cloud) { return !cloud.expired(); });
    EXPECT_LE(in_memory, 20) << clouds.size();
    EXPECT_GT(clouds.size(), 40U);
    ASSERT_EQ(mapping.localisation()->result == LocalisationResult::found, known);
    std::size_t number = 0;
    const GraphSnapshotPtr travelled = mapping.travelled();
    for (const auto& [id, keyframe] : travelled->keyframes) {
      const CloudPtr cloud = keyframe.cloud.get();
      ASSERT_NE(cloud, nullptr);
      EXPECT_EQ(cloud->size(), 10 + number++);
    }
    EXPECT_EQ(number, walk.size());
  }
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

// A thing on the floor that is seen from all sides.
void add_box(MappedBuilding& building, const Eigen::Vector2d& low, const Eigen::Vector2d& size) {
  const Eigen::Vector2d right(size.x(), 0);
  building.add_face(low + right, low);
  building.add_face(low + size, low + right);
  building.add_face(low + size - right, low + size);
  building.add_face(low, low + size - right);
}

// Between two visits a wall was built, a door shut and a cabinet moved; nothing else is told, and nothing of two visits between which nothing
// happened.
TEST(Changes, TellWhatIsOtherwise) {
  const Folder folder;
  BuildingNoise noise;
  noise.clouds = true;
  MappedBuilding before = flat();
  add_box(before, {9.6, 0.4}, {1.0, 0.6});
  write_map_of(before.walk(flat_way(), 0.6, 0.3, noise, 14), folder.file("a.sgmap"));
  const Pose T_world_map = before.walk(flat_way(), 0.6, 0.3, noise, 14).front().T_world_base *
                           read_map(folder.file("a.sgmap"), Clouds::none).poses.begin()->second.inverse();

  MappedBuilding after;
  after.add_room(0, 5.8, 16, 7.85, {{{12.0, 13.0}}, {}, {}, {}});
  after.add_room(9.2, 0, 16, 5.65, {{}, {}, {{3.0, 4.0}}, {}});
  add_box(after, {9.6, 1.3}, {1.0, 0.6});
  after.add_face({14.4, 0}, {14.4, 3});
  after.add_face({14.5, 3}, {14.5, 0});
  const Way way{{2, 6.8},  {12.5, 6.8}, {12.5, 4}, {13.5, 4.5}, {15.3, 4.5}, {15.3, 1.5}, {15.3, 4.5},
                {12.5, 4}, {12.5, 1.5}, {11.5, 1}, {11.5, 3},   {12.5, 4},   {12.5, 6.8}, {2, 6.8}};
  write_map_of(after.walk(way, 0.6, 0.2, noise, 15), folder.file("b.sgmap"));
  write_map_of(before.walk(flat_way(), 0.6, 0.2, noise, 16), folder.file("same.sgmap"));

  const auto merged = [&](const char* other) {
    const StoredMap second = read_map(folder.file(other), Clouds::none);
    const Localisation place = add_session(second, 0, folder.file("a.sgmap"), folder.file(std::string("with_") + other), {}, {});
    EXPECT_EQ(place.result, LocalisationResult::found) << place.reason;
    return changes_of(read_map(folder.file(std::string("with_") + other), Clouds::none), 1);
  };
  for (const MapChange& change : merged("same.sgmap")) ADD_FAILURE() << to_string(change);

  // Where in the map, which begins with the walk.
  const auto in_map = [&T_world_map](double x, double y) -> Eigen::Vector2d { return (T_world_map.inverse() * Eigen::Vector3d(x, y, 0)).head<2>(); };
  std::map<MapChange::Kind, std::vector<MapChange>> found;
  for (const MapChange& change : merged("b.sgmap")) {
    found[change.kind].push_back(change);
    if (change.kind != MapChange::Kind::door_closed && change.kind != MapChange::Kind::wall_new && change.kind != MapChange::Kind::moved)
      ADD_FAILURE() << to_string(change);
  }
  ASSERT_EQ(found[MapChange::Kind::door_closed].size(), 1U);
  EXPECT_LT((found[MapChange::Kind::door_closed].front().center - in_map(4.5, 5.75)).norm(), 0.25);
  EXPECT_NEAR(found[MapChange::Kind::door_closed].front().length, 1, 0.3);
  ASSERT_EQ(found[MapChange::Kind::wall_new].size(), 1U);
  EXPECT_LT((found[MapChange::Kind::wall_new].front().center - in_map(14.45, 1.5)).norm(), 0.3);
  EXPECT_NEAR(found[MapChange::Kind::wall_new].front().length, 3, 0.4);
  ASSERT_EQ(found[MapChange::Kind::moved].size(), 1U);
  EXPECT_LT((found[MapChange::Kind::moved].front().from - in_map(10.1, 0.7)).norm(), 0.6);
  EXPECT_LT((found[MapChange::Kind::moved].front().center - in_map(10.1, 1.6)).norm(), 0.6);
  EXPECT_EQ(to_string(found[MapChange::Kind::door_closed].front()).rfind("door closed: ", 0), 0U);
}

// A door through which the robot walked on its first visit is shut on the second: its leaf is a plane of the map, seen as often as there was
// something to see, and not taken for something that the robot can walk through.
TEST(MergeMaps, KeepWhatWasShutSinceTheRobotWalkedThroughIt) {
  const Folder folder;
  write_map_of(walked(flat_way(), 17), folder.file("a.sgmap"));
  MappedBuilding after;
  after.add_room(0, 5.8, 16, 7.85, {{{4.0, 5.0}, {12.0, 13.0}}, {}, {}, {}});
  after.add_room(9.2, 0, 16, 5.65, {{}, {}, {{3.0, 4.0}}, {}});
  after.add_face({4.0, 5.6}, {5.0, 5.6});  // the leaf, set back
  const Way way{{2, 6.8}, {7, 6.8}, {4.5, 7}, {2, 6.8}, {12.5, 6.8}, {12.5, 4}, {14, 2}, {11, 2}, {12.5, 4}, {12.5, 6.8}, {2, 6.8}};
  const auto second = after.walk(way, 0.6, 0.2, {}, 18);
  write_map_of(second, folder.file("b.sgmap"));
  const Localisation place = add_session(read_map(folder.file("b.sgmap"), Clouds::none), 0, folder.file("a.sgmap"), folder.file("c.sgmap"), {}, {});
  ASSERT_EQ(place.result, LocalisationResult::found) << place.reason;
  const GraphSnapshot both = snapshot_of(read_map(folder.file("c.sgmap"), Clouds::none));
  const Pose T_map_world = both.keyframes.rbegin()->second.T_map_base * second.back().T_world_base.inverse();
  const Eigen::Vector3d leaf = T_map_world * Eigen::Vector3d(4.5, 5.6, 1);
  const Eigen::Vector3d out = T_map_world.rotation * Eigen::Vector3d::UnitY();
  std::size_t seen = 0;
  for (const auto& [id, plane] : both.planes) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const auto& p : plane.extent) center += p / static_cast<double>(plane.extent.size());
    if (plane.plane.normal.dot(out) > 0.98 && std::abs(plane.plane.distance(leaf)) < 0.06 && (center - leaf).head<2>().norm() < 0.6)
      seen = std::max(seen, plane.keyframes.size());
  }
  EXPECT_GE(seen, 6U);
}

TEST(StartPose, IsFourNumbers) {
  const Pose pose = parse_start_pose("1 -2 0.5 1.57");
  EXPECT_EQ(pose.translation, Eigen::Vector3d(1, -2, 0.5));
  EXPECT_NEAR((pose.rotation * Eigen::Vector3d::UnitX()).y(), 1, 1e-4);
  for (const char* text : {"", "1 2 3", "1 2 3 4 5", "a b c d", "1 2 3 nan"}) EXPECT_THROW(parse_start_pose(text), std::runtime_error) << text;
}

}  // namespace
}  // namespace sgraph
