#include "sgraph_slam/core/mapping/back_end.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "support/mapping_run.hpp"

namespace sgraph {
namespace {

TEST(BackEnd, MapsAnOfficeAtAnyHeading) {
  const MappedBuilding building = office();
  for (const double degrees : {0.0, 20.0, 44.9}) {
    const auto walk = building.walk(office_walk(), 0.75, degrees * M_PI / 180, {}, 3);
    const Outcome result = map_walk(walk, {});
    EXPECT_EQ(result.snapshot->rooms.size(), 4U) << degrees;
    EXPECT_EQ(result.snapshot->corridors.size(), 1U) << degrees;
    EXPECT_LT(result.ate, 0.01);
    EXPECT_LT(result.ate, result.odometry_ate);
  }
}

// The player optimises at the end of a bag, and saving does again: the live map must not differ from the offline one by that.
TEST(BackEnd, OptimisingTwiceChangesNothing) {
  const MappedBuilding building = office();
  const auto walk = building.walk(office_walk(), 0.75, 0.3, {}, 3);
  BackEnd back_end({}, MappedBuilding::T_base_lidar());
  for (const SeenKeyframe& seen : walk) back_end.process(seen.keyframe, seen.segments);
  const GraphSnapshotPtr once = back_end.optimize();
  const GraphSnapshotPtr twice = back_end.optimize();
  EXPECT_EQ(once->version, twice->version);
  ASSERT_EQ(once->planes.size(), twice->planes.size());
  for (const auto& [id, keyframe] : once->keyframes) EXPECT_EQ(keyframe.T_map_base.translation, twice->keyframes.at(id).T_map_base.translation);
}

// Where a wall becomes thinner a plane fitted to both parts would lie aslant between them, and fit either; and the room would show both to be one
// side.
TEST(BackEnd, TwoPartsOfAWallOfDifferentThicknessStayTwoPlanes) {
  MappedBuilding building;
  building.add_face({0, 0}, {8, 0});
  building.add_face({8, 0}, {8, 3.5});
  building.add_face({8.05, 3.5}, {8.05, 8});
  building.add_face({8.05, 8}, {0, 8});
  building.add_face({0, 8}, {0, 0});
  const Eigen::Vector2d start(2, 2);
  const auto walk = building.walk({start, {6.5, 2}, {6.5, 6}, {2, 6}, start, {6.5, 4}, {2, 4}, start}, 0.5, 0.4, {}, 6);
  const Outcome result = map_walk(walk, {});
  EXPECT_EQ(result.snapshot->rooms.size(), 1U);
  EXPECT_LT(result.ate, 0.005);
  const Pose T_map_world = walk.front().keyframe.T_odom_base * walk.front().T_world_base.inverse();
  const Eigen::Vector3d east = T_map_world.rotation * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d corner = T_map_world * Eigen::Vector3d(8, 3.5, 1);
  std::vector<double> beyond;
  for (const auto& [id, plane] : result.snapshot->planes) {
    if (plane.plane.normal.dot(east) > -0.99 || plane.keyframes.size() < 5) continue;
    EXPECT_NEAR(plane.plane.normal.dot(east), -1, 1e-5) << "aslant";
    beyond.push_back(plane.plane.distance(corner));
  }
  std::sort(beyond.begin(), beyond.end());
  ASSERT_EQ(beyond.size(), 2U);
  EXPECT_NEAR(beyond[1] - beyond[0], 0.05, 0.006);
}

// Now and then segmentation lays a plane through a wall and a cupboard before it: seen once, a little off the wall. It isn't a second wall.
TEST(BackEnd, AGhostBesideAWallIsDropped) {
  const MappedBuilding building = office();
  auto walk = building.walk(office_walk(), 0.75, 0.3, {}, 5);
  const std::size_t clean = map_walk(walk, {}).snapshot->planes.size();
  for (std::size_t i = 2; i < walk.size(); i += 7) {
    auto& segments = walk[i].segments.segments;
    PlaneSegment ghost = segments.front();
    for (const PlaneSegment& s : segments) {
      if (std::abs(s.plane.normal.z()) < 0.1 && s.count > ghost.count) ghost = s;
    }
    if (std::abs(ghost.plane.normal.z()) > 0.1) continue;
    const Eigen::Quaterniond turn = so3_exp({0, 0, i % 2 == 0 ? 0.05 : -0.05});
    const Eigen::Vector3d shift = (0.06 + 0.01 * static_cast<double>(i % 5)) * ghost.plane.normal;
    const auto moved = [&](const Eigen::Vector3d& p) { return Eigen::Vector3d(turn * (p - ghost.centroid) + ghost.centroid + shift); };
    for (Eigen::Vector3d& corner : ghost.extent) corner = moved(corner);
    ghost.plane.normal = turn * ghost.plane.normal;
    ghost.centroid += shift;
    ghost.plane.d = -ghost.plane.normal.dot(ghost.centroid);
    segments.push_back(ghost);
  }
  MappingParams never;
  never.association.ghost_distance = 0;
  const std::size_t with_ghosts = map_walk(walk, never).snapshot->planes.size() - clean;
  EXPECT_GE(with_ghosts, 8U);
  // Some lie on each other and look like a surface.
  EXPECT_LE(map_walk(walk, {}).snapshot->planes.size() - clean, with_ghosts / 2);
}

// A wall and the cupboard before it, taken for one by three keyframes in a row: seen too often for a chance, but no wall leans against another.
TEST(BackEnd, APlaneThatLeansAgainstAWallIsDropped) {
  const MappedBuilding building = office();
  auto walk = building.walk(office_walk(), 0.75, 0.3, {}, 5);
  const std::size_t clean = map_walk(walk, {}).snapshot->planes.size();
  const auto T_world_lidar = [](const SeenKeyframe& seen) { return seen.T_world_base * MappedBuilding::T_base_lidar(); };
  const SeenKeyframe& first = walk[2];
  PlaneSegment wall;
  for (const PlaneSegment& s : first.segments.segments) {
    if (std::abs(s.plane.normal.z()) < 0.1 && s.count > wall.count) wall = s;
  }
  const Pose lean{so3_exp({0, 0, 0.04}), 0.06 * wall.plane.normal + wall.centroid - so3_exp({0, 0, 0.04}) * wall.centroid};
  const Pose T_world_first = T_world_lidar(first);
  for (std::size_t i = 2; i < 5; ++i) {
    const Pose moved = T_world_lidar(walk[i]).inverse() * T_world_first * lean;
    PlaneSegment ghost = wall;
    for (Eigen::Vector3d& corner : ghost.extent) corner = moved * corner;
    ghost.plane = moved * wall.plane;
    ghost.centroid = moved * wall.centroid;
    walk[i].segments.segments.push_back(ghost);
  }
  MappingParams never;
  never.association.ghost_distance = 0;
  EXPECT_EQ(map_walk(walk, never).snapshot->planes.size(), clean + 1);
  EXPECT_EQ(map_walk(walk, {}).snapshot->planes.size(), clean);
}

}  // namespace
}  // namespace sgraph
