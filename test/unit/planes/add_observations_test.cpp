#include "sgraph_slam/core/planes/add_observations.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sgraph_slam/core/planes/association.hpp"
#include "sgraph_slam/core/planes/merging.hpp"
#include "sgraph_slam/core/types/storey.hpp"
#include "support/mapped_building.hpp"

namespace sgraph {
namespace {

// A wall seen across from a robot: its points in the LiDAR's frame.
PlaneSegment wall(double yaw, double distance, double length) {
  std::vector<Eigen::Vector3d> points;
  const Eigen::Vector3d out(std::cos(yaw), std::sin(yaw), 0);
  const Eigen::Vector3d along(-out.y(), out.x(), 0);
  for (int i = 0; i <= 20; ++i) {
    for (int k = 0; k <= 8; ++k)
      points.push_back(distance * out + (i / 20.0 - 0.5) * length * along + Eigen::Vector3d(0, 0, 0.25 * k - 0.5) + 0.001 * ((i + k) % 3) * out);
  }
  return fit_segment(points, 0.02);
}

// Which segment went where is said by association; it can't be found out afterwards from outlines, which turn round when a segment's side does.
TEST(AddObservations, SaysWhichPlaneEachSegmentWasTakenFor) {
  Graph graph;
  DecisionLog log;
  Committer committer{graph, log};
  PlaneLayer planes({}, {});
  Keyframe keyframe;
  PlaneSegments segments;
  segments.segments = {wall(0, 3, 4), wall(1.5, 4, 5), wall(-1.5, 2, 0.1), wall(3, 3, 4)};
  segments.segments[1].plane.d = std::nan("");
  for (std::int64_t k = 0; k < 2; ++k) {
    keyframe.id = {k};
    Transaction edit;
    edit.keyframes[keyframe.id] = {};
    if (k > 0) add_factor(edit, Se3Between{{0}, {1}, Pose{}, SqrtInformation<6>::from_std_dev(Vector6::Constant(0.01))});
    ASSERT_TRUE(committer.commit(edit).ok());
    planes.drift.add(keyframe.id, {}, 1e-4 * Matrix6::Identity());
    if (k == 1) std::swap(segments.segments[0], segments.segments[3]);
    const AssociationResult seen = add_observations(committer, planes, keyframe, segments);
    ASSERT_EQ(seen.planes.size(), 4U);
    EXPECT_EQ(seen.planes[k == 0 ? 0 : 3], PlaneId{0});
    EXPECT_FALSE(seen.planes[1].valid());  // no number
    EXPECT_FALSE(seen.planes[2].valid());  // too small for a plane
    EXPECT_EQ(seen.planes[k == 0 ? 3 : 0], PlaneId{1});
    EXPECT_EQ(seen.ignored, 2);
    EXPECT_EQ(k == 0 ? seen.created : seen.matched, 2);
  }
  // Walked past a wall that it also saw from before: of unsure side, known only from behind.
  keyframe.id = {2};
  Transaction edit;
  edit.keyframes[keyframe.id] = {};
  add_factor(edit, Se3Between{{1}, {2}, Pose{}, SqrtInformation<6>::from_std_dev(Vector6::Constant(0.01))});
  ASSERT_TRUE(committer.commit(edit).ok());
  planes.drift.add(keyframe.id, {}, 1e-4 * Matrix6::Identity());
  keyframe.scans = {{{0}, Pose{Eigen::Quaterniond::Identity(), {5, 0, 0}}}, {{1}, Pose{}}};
  PlaneSegments turned;
  turned.segments = {flipped(wall(0, 3, 4))};
  const AssociationResult seen = add_observations(committer, planes, keyframe, turned);
  ASSERT_EQ(seen.planes.size(), 1U);
  EXPECT_EQ(seen.planes[0], PlaneId{0});
}

// Two floors that look alike: the same wall in the same place but for the storey.
TEST(AddObservations, TakesNothingOfAnotherStoreyForKnown) {
  Graph graph;
  DecisionLog log;
  Committer committer{graph, log};
  PlaneLayer planes({}, {});
  PlaneSegments segments;
  segments.segments = {wall(0, 3, 4)};
  const auto see = [&](std::int64_t k, int storey) {
    Keyframe keyframe;
    keyframe.id = {k};
    Transaction edit;
    edit.keyframes[keyframe.id] = {};
    if (k > 0) add_factor(edit, Se3Between{{k - 1}, {k}, Pose{}, SqrtInformation<6>::from_std_dev(Vector6::Constant(0.01))});
    EXPECT_TRUE(committer.commit(edit).ok());
    planes.drift.add(keyframe.id, {}, 1e-4 * Matrix6::Identity());
    planes.storeys[keyframe.id] = storey;
    return add_observations(committer, planes, keyframe, segments).planes.at(0);
  };
  EXPECT_EQ(see(0, 0), PlaneId{0});
  EXPECT_EQ(see(1, 1), PlaneId{1});
  EXPECT_EQ(see(2, 0), PlaneId{0});
  EXPECT_EQ(see(3, stairwell), PlaneId{2});
  EXPECT_EQ(see(4, stairwell), PlaneId{2});
  EXPECT_EQ(planes.map.find({1})->storey, 1);
  EXPECT_TRUE(merge_candidates(graph, planes.map, planes.params.merging, 1.0).empty());
  // What was taken for the stairwell was a storey already.
  std::map<KeyframeId, int> storeys = planes.storeys;
  storeys[{3}] = storeys[{4}] = 2;
  set_storeys(planes, storeys);
  EXPECT_EQ(planes.map.find({2})->storey, 2);
  EXPECT_EQ(planes.map.find({0})->storey, 0);
}

TEST(PathOn, JoinsNoTwoVisitsToAStorey) {
  Graph graph;
  DecisionLog log;
  Committer committer{graph, log};
  PlaneLayer planes({}, {});
  const std::vector<double> x{0, 1, 2, 9, 10};
  for (std::size_t k = 0; k < x.size(); ++k) {
    const KeyframeId id{static_cast<std::int64_t>(k)};
    Transaction edit;
    edit.keyframes[id] = Pose{Eigen::Quaterniond::Identity(), {x[k], 0, 0}};
    if (k > 0) add_factor(edit, Se3Between{{id.value - 1}, id, Pose{}, SqrtInformation<6>::from_std_dev(Vector6::Constant(0.01))});
    ASSERT_TRUE(committer.commit(edit).ok());
    planes.storeys[id] = k == 2 ? 1 : 0;
  }
  const GroundPath path = path_on(graph, planes, 0);
  ASSERT_EQ(path.points().size(), 4U);
  EXPECT_FALSE(path.steps_near({0.5, -1}, {0.5, 1}).empty());
  EXPECT_TRUE(path.steps_near({4.5, -1}, {4.5, 1}).empty());  // between the first visit and the second
  EXPECT_FALSE(path.steps_near({9.5, -1}, {9.5, 1}).empty());
}

}  // namespace
}  // namespace sgraph
