// Rides in a lift: the odometry says that a motion's height is unknown, the back end makes of it another storey, or a known one.

#include <gtest/gtest.h>

#include <optional>
#include <set>
#include <vector>

#include "support/mapping_run.hpp"

namespace sgraph {
namespace {

// The cabin, 2 x 1.8 m, opens to the south, where each floor has walls of its own.
MappedBuilding with_cabin(const MappedBuilding& floor) {
  MappedBuilding building = floor;
  building.add_room(4, 6.2, 6, 8, {{{0.5, 1.5}}, {}, {}, {}});
  return building;
}

MappedBuilding ground_floor() {
  MappedBuilding floor;
  floor.add_room(0, 0, 10, 6, {{}, {}, {{4.5, 5.5}}, {}});
  return with_cabin(floor);
}

MappedBuilding upper_floor() {
  MappedBuilding floor;
  floor.add_room(2, -3, 13, 6, {{}, {}, {{7.5, 8.5}}, {}});
  floor.add_face({8, 6}, {8, 2});
  floor.add_face({8.15, 2}, {8.15, 6});
  return with_cabin(floor);
}

MappedBuilding top_floor() {
  MappedBuilding floor;
  floor.add_room(-3, 2, 7, 6, {{}, {}, {{1.5, 2.5}}, {}});
  return with_cabin(floor);
}

const std::vector<Eigen::Vector2d> ground_walk{{2, 2}, {8, 2}, {8, 4.5}, {2, 4}, {5, 3}, {5, 7}};
const std::vector<Eigen::Vector2d> upper_walk{{5, 7}, {5, 3}, {10, 0}, {11, 4}, {11, -1}, {4, -1}, {5, 3}, {5, 7}};
const std::vector<Eigen::Vector2d> top_walk{{5, 7}, {5, 3}, {-1, 3}, {-1, 5}, {5, 4}, {5, 7}};
const std::vector<Eigen::Vector2d> way_back{{5, 7}, {5, 3}, {8, 4.5}, {2, 2}};

// Several walks as one recording, a ride between each and the next.
class Recording {
 public:
  static constexpr double height_sigma = 0.1;  // of a ride that was measured [m]

  void add(const MappedBuilding& building, const std::vector<Eigen::Vector2d>& waypoints, std::optional<double> risen = {}) {
    std::vector<SeenKeyframe> part = building.walk(waypoints, 0.75, 0.3, {}, 3 + static_cast<unsigned>(starts_.size()));
    starts_.push_back(all_.size());
    const Pose T_odom_part = all_.empty() ? Pose{}
                                          : all_.back().keyframe.T_odom_base * (all_.back().T_world_base.inverse() * part.front().T_world_base) *
                                                part.front().keyframe.T_odom_base.inverse();
    if (!all_.empty()) {
      Keyframe& first = part.front().keyframe;
      first.ride = risen ? Rise{*risen, height_sigma} : unknown_rise;
      first.covariance = Matrix6::Identity() * 1e-5;
      first.covariance(5, 5) = 100;
    }
    for (SeenKeyframe& seen : part) {
      seen.keyframe.id = {static_cast<std::int64_t>(all_.size())};
      seen.keyframe.stamp = Stamp::from_seconds(static_cast<double>(all_.size()));
      seen.segments.stamp = seen.keyframe.stamp;
      seen.keyframe.T_odom_base = T_odom_part * seen.keyframe.T_odom_base;
      for (StampedPose& scan : seen.keyframe.scans) scan = {seen.keyframe.stamp, seen.keyframe.T_odom_base};
      all_.push_back(seen);
    }
  }

  [[nodiscard]] const std::vector<SeenKeyframe>& all() const { return all_; }
  /// Storeys of the keyframes of one walk.
  [[nodiscard]] std::set<int> storeys(const GraphSnapshot& snapshot, std::size_t walk) const {
    std::set<int> found;
    const std::size_t end = walk + 1 < starts_.size() ? starts_[walk + 1] : all_.size();
    for (std::size_t i = starts_[walk]; i < end; ++i) found.insert(snapshot.keyframes.at(all_[i].keyframe.id).storey);
    return found;
  }
  /// Largest error of position and heading on the ground.
  void expect_close(const GraphSnapshot& snapshot, double distance, double angle) const {
    const Pose T_world_map = all_.front().T_world_base * snapshot.keyframes.at(all_.front().keyframe.id).T_map_base.inverse();
    for (const SeenKeyframe& seen : all_) {
      const Pose error = seen.T_world_base.inverse() * T_world_map * snapshot.keyframes.at(seen.keyframe.id).T_map_base;
      EXPECT_LT((seen.T_world_base.rotation * error.translation).head<2>().norm(), distance) << seen.keyframe.id.value;
      EXPECT_LT(std::abs(2 * error.rotation.z()), angle) << seen.keyframe.id.value;
    }
  }

 private:
  std::vector<SeenKeyframe> all_;
  std::vector<std::size_t> starts_;
};

void expect_no_plane_across(const GraphSnapshot& snapshot) {
  for (const auto& [id, plane] : snapshot.planes) {
    std::set<int> storeys;
    for (const KeyframeId seen : plane.keyframes) storeys.insert(snapshot.keyframes.at(seen).storey);
    EXPECT_EQ(storeys.size(), 1U) << "plane " << id.value;
  }
}

TEST(LiftRide, LeadsToAStoreyOfUnknownHeightAndBackToTheKnownOne) {
  Recording recording;
  recording.add(ground_floor(), ground_walk);
  recording.add(upper_floor(), upper_walk);
  recording.add(ground_floor(), way_back);
  const Outcome result = map_walk(recording.all(), {});
  const GraphSnapshot& map = *result.snapshot;
  EXPECT_EQ(recording.storeys(map, 0), std::set<int>{0});
  EXPECT_EQ(recording.storeys(map, 1), std::set<int>{1});
  EXPECT_EQ(recording.storeys(map, 2), std::set<int>{0});
  ASSERT_EQ(map.storeys.size(), 2U);
  EXPECT_TRUE(map.storeys[0].height_known);
  EXPECT_FALSE(map.storeys[1].height_known);
  expect_no_plane_across(map);
  recording.expect_close(map, 0.02, 0.003);
}

TEST(LiftRide, AThirdFloorIsNotTakenForAKnownOne) {
  Recording recording;
  recording.add(ground_floor(), ground_walk);
  recording.add(upper_floor(), upper_walk);
  recording.add(top_floor(), top_walk);
  const Outcome result = map_walk(recording.all(), {});
  EXPECT_EQ(recording.storeys(*result.snapshot, 2), std::set<int>{2});
  EXPECT_EQ(result.snapshot->storeys.size(), 3U);
}

TEST(LiftRide, ThatWasMeasuredLeadsToAStoreyOfKnownHeight) {
  Recording recording;
  recording.add(ground_floor(), ground_walk);
  recording.add(upper_floor(), upper_walk, 3.3);
  recording.add(ground_floor(), way_back, -3.1);
  const Outcome result = map_walk(recording.all(), {});
  const GraphSnapshot& map = *result.snapshot;
  EXPECT_EQ(recording.storeys(map, 1), std::set<int>{1});
  EXPECT_EQ(recording.storeys(map, 2), std::set<int>{0});
  ASSERT_EQ(map.storeys.size(), 2U);
  EXPECT_TRUE(map.storeys[1].height_known);
  EXPECT_NEAR(map.storeys[1].height_sigma, Recording::height_sigma / std::sqrt(2), 0.01);  // both rides count
  EXPECT_EQ(map.storeys[0].height_sigma, 0);
  EXPECT_NEAR(map.storeys[1].z - map.storeys[0].z, 3.2, 0.02);
  recording.expect_close(map, 0.02, 0.003);
}

// By its walls alone it is the floor that was left (ARideToWhereItBeganIsNone).
TEST(LiftRide, ThatWasMeasuredTellsFloorsApartThatLookAlike) {
  Recording recording;
  recording.add(ground_floor(), ground_walk);
  recording.add(ground_floor(), way_back, 3.2);
  const Outcome result = map_walk(recording.all(), {});
  EXPECT_EQ(recording.storeys(*result.snapshot, 1), std::set<int>{1});
}

// People before the door: the odometry took the floor that was left for another one.
TEST(LiftRide, ARideToWhereItBeganIsNone) {
  Recording recording;
  recording.add(ground_floor(), ground_walk);
  recording.add(ground_floor(), way_back);
  const Outcome result = map_walk(recording.all(), {});
  EXPECT_EQ(recording.storeys(*result.snapshot, 1), std::set<int>{0});
}

}  // namespace
}  // namespace sgraph
