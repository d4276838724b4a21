#include "sgraph_slam/core/eval/wall_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

PlanWall wall(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  PlanWall w;
  w.p = p;
  w.q = q;
  w.thickness = 0.2;
  w.height = 3;
  return w;
}

// Two rooms of 5 x 4 m side by side, a door in the wall between them: outer walls 10 x 4 m, partition at x = 5.
Plan two_rooms() {
  Plan plan;
  plan.walls = {wall({0, 0}, {10, 0}), wall({10, 0}, {10, 4}), wall({10, 4}, {0, 4}), wall({0, 4}, {0, 0}), wall({5, 0}, {5, 4})};
  plan.walls[4].openings = {{1.5, 2.5, 0, 2.1, false}};
  return plan;
}

std::vector<Pose> poses(std::initializer_list<Eigen::Vector2d> places) {
  std::vector<Pose> all;
  for (const Eigen::Vector2d& p : places) all.push_back({Eigen::Quaterniond::Identity(), {p.x(), p.y(), 0.5}});
  return all;
}

const WallFace* face_at(const std::vector<WallFace>& faces, std::size_t wall_index, const Eigen::Vector2d& normal, const Eigen::Vector2d& middle) {
  for (const WallFace& f : faces) {
    if (f.wall == wall_index && f.normal.dot(normal) > 0.99 && (0.5 * (f.begin + f.end) - middle).norm() < 0.15) return &f;
  }
  return nullptr;
}

TEST(WallFaces, AreDividedWhereAnotherWallAbuts) {
  const auto faces = wall_faces(two_rooms(), poses({{2.5, 2}}));
  const WallFace* left = face_at(faces, 0, {0, 1}, {2.5, 0.1});
  const WallFace* right = face_at(faces, 0, {0, 1}, {7.5, 0.1});
  const WallFace* outside = face_at(faces, 0, {0, -1}, {5, -0.1});
  ASSERT_TRUE(left && right && outside);
  EXPECT_NEAR(left->length(), 4.8, 0.11);
  EXPECT_NEAR(left->begin.y(), 0.1, 1e-9);
  EXPECT_NEAR(outside->length(), 10, 0.11);
  EXPECT_EQ(outside->seen_length, 0);
}

TEST(WallFaces, AreSeenWithinRangeAndNotThroughWalls) {
  const auto faces = wall_faces(two_rooms(), poses({{2.5, 2}}));
  EXPECT_NEAR(face_at(faces, 0, {0, 1}, {2.5, 0.1})->seen_length, 4.8, 0.21);
  EXPECT_NEAR(face_at(faces, 4, {-1, 0}, {4.9, 2})->seen_length, 3.8 - 1, 0.21);  // less the door
  EXPECT_EQ(face_at(faces, 4, {1, 0}, {5.1, 2})->seen_length, 0);                 // its other side
  EXPECT_EQ(face_at(faces, 0, {0, 1}, {7.5, 0.1})->seen_length, 0);               // the other room's wall
  // Through the door, 6 m away: x = 9.9 is out of range, from nearer some of it shows.
  EXPECT_EQ(face_at(faces, 1, {-1, 0}, {9.9, 2})->seen_length, 0);
  const auto nearer = wall_faces(two_rooms(), poses({{4.3, 2}}));
  // Seen from (4.3, 2) between the door's far edges (5.1, 1.5) and (5.1, 2.5): 5.6 / 0.8 times their half metre is beyond the wall, and the near
  // edges (4.9) let through more; so all of it, at up to 19 degrees from the normal.
  EXPECT_NEAR(face_at(nearer, 1, {-1, 0}, {9.9, 2})->seen_length, 3.8, 0.21);
  EXPECT_EQ(wall_faces(two_rooms(), poses({{4.3, 2}}), 5).size(), nearer.size());
  EXPECT_EQ(face_at(wall_faces(two_rooms(), poses({{4.3, 2}}), 5), 1, {-1, 0}, {9.9, 2})->seen_length, 0);
}

TEST(WallFaces, GlassLetsThroughAndIsNoFace) {
  Plan plan = two_rooms();
  plan.walls[4].glass = true;
  const auto faces = wall_faces(plan, poses({{4.3, 2}}));
  EXPECT_GT(face_at(faces, 1, {-1, 0}, {9.9, 2})->seen_length, 3);
  for (const WallFace& f : faces) EXPECT_NE(f.wall, 4u);
}

const Pose T_truth_map = se3_exp((Vector6() << 0.01, -0.02, 0.8, 3, -4, 1).finished());

// A mapped plane that lies on a face from a to b, moved by `offset` along its normal and turned by `turn` about the vertical through its middle.
ScenePlane plane_on(std::int64_t id, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& normal, double offset = 0,
                    double turn = 0) {
  const Eigen::Vector3d n = so3_exp({0, 0, turn}) * Eigen::Vector3d(normal.x(), normal.y(), 0);
  const Eigen::Vector2d middle = 0.5 * (a + b) + offset * normal;
  const Plane truth_plane{n, -n.dot(Eigen::Vector3d(middle.x(), middle.y(), 0))};
  ScenePlane plane;
  plane.id = {id};
  plane.plane = T_truth_map.inverse() * truth_plane;
  for (const auto& [p, z] : {std::pair{a, 0.2}, {b, 0.2}, {b, 2.5}, {a, 2.5}})
    plane.extent.push_back(T_truth_map.inverse() * Eigen::Vector3d(p.x(), p.y(), z));
  return plane;
}

TEST(WallScore, MeasuresNormalAndPosition) {
  const auto faces = wall_faces(two_rooms(), poses({{2.5, 2}}));
  // All four walls of the left room; the partition's face is 2.8 m of surface in view.
  const std::vector<ScenePlane> planes{plane_on(0, {0.1, 0.1}, {4.9, 0.1}, {0, 1}, 0.003),
                                       plane_on(1, {4.9, 0.1}, {4.9, 3.9}, {-1, 0}, -0.004, 0.002), plane_on(2, {4.9, 3.9}, {0.1, 3.9}, {0, -1}),
                                       plane_on(3, {0.1, 0.1}, {0.1, 3.9}, {1, 0})};
  const WallScore score = score_walls(planes, T_truth_map, faces);
  EXPECT_EQ(score.faces, 4);
  ASSERT_EQ(score.matches.size(), 4u);
  EXPECT_EQ(score.recall(), 1);
  EXPECT_EQ(score.duplicates, 0);
  EXPECT_TRUE(score.other_planes.empty());
  for (const WallMatch& m : score.matches) {
    EXPECT_NEAR(m.position_error, m.plane == 0 ? 0.003 : m.plane == 1 ? 0.004 : 0, 1e-4) << m.plane;
    EXPECT_NEAR(m.normal_error, m.plane == 1 ? 0.002 : 0, 1e-9) << m.plane;
  }
  EXPECT_NEAR(score.position_error().max, 0.004, 1e-4);
}

TEST(WallScore, OppositeFaceTurnedShiftedOrElsewhereIsNoMatch) {
  const auto faces = wall_faces(two_rooms(), poses({{2.5, 2}}));
  const std::vector<ScenePlane> planes{plane_on(0, {0.1, 0.1}, {4.9, 0.1}, {0, -1}),          // looks into the wall
                                       plane_on(1, {4.9, 0.1}, {4.9, 3.9}, {-1, 0}, 0, 0.1),  // 6 degrees off
                                       plane_on(2, {4.9, 3.9}, {0.1, 3.9}, {0, -1}, 0.2),     // a cupboard's front
                                       plane_on(3, {0.1, -6}, {0.1, -2}, {1, 0})};            // its continuation elsewhere
  const WallScore score = score_walls(planes, T_truth_map, faces);
  EXPECT_EQ(score.matches.size(), 0u);
  EXPECT_EQ(score.missed.size(), 4u);
  EXPECT_EQ(score.recall(), 0);
  EXPECT_EQ(score.reversed_planes, (std::vector<std::int64_t>{0}));
  EXPECT_EQ(score.other_planes, (std::vector<std::int64_t>{1, 2, 3}));
}

TEST(WallScore, CountsDuplicatesAndIgnoresFloors) {
  const auto faces = wall_faces(two_rooms(), poses({{2.5, 2}}));
  ScenePlane floor = plane_on(9, {0.1, 0.1}, {4.9, 0.1}, {0, 1});
  floor.plane = T_truth_map.inverse() * Plane{Eigen::Vector3d::UnitZ(), 0};
  const WallScore score =
      score_walls({plane_on(0, {0.1, 0.1}, {2, 0.1}, {0, 1}), plane_on(1, {1.5, 0.1}, {4.9, 0.1}, {0, 1}, 0.02), floor}, T_truth_map, faces);
  ASSERT_EQ(score.matches.size(), 1u);
  EXPECT_EQ(score.matches[0].plane, 1);  // the longer one
  EXPECT_EQ(score.matches[0].more, std::vector<std::int64_t>{0});
  EXPECT_EQ(score.duplicates, 1);
  EXPECT_DOUBLE_EQ(score.duplicate_share(), 1);
  EXPECT_TRUE(score.other_planes.empty());
}

// One wall continued by a thinner one, faces 5 cm apart: the plane of each, seen as one long stretch, is no second plane of the other.
TEST(WallScore, APlaneAlongWallsInOneLineLiesOnTheNearest) {
  Plan plan;
  plan.walls = {wall({0, 0}, {5, 0}), wall({5, 0}, {10, 0})};
  plan.walls[1].thickness = 0.3;
  const auto faces = wall_faces(plan, poses({{2.5, 2}, {7.5, 2}}));
  const WallScore score = score_walls({plane_on(0, {0, 0.1}, {10, 0.1}, {0, 1}), plane_on(1, {0, 0.15}, {10, 0.15}, {0, 1})}, T_truth_map, faces);
  ASSERT_EQ(score.matches.size(), 2u);
  EXPECT_EQ(score.duplicates, 0);
  for (const WallMatch& m : score.matches) EXPECT_NEAR(m.position_error, 0, 1e-6) << m.plane;
  const WallScore doubled = score_walls({plane_on(0, {0, 0.1}, {10, 0.1}, {0, 1}), plane_on(1, {0, 0.11}, {5, 0.11}, {0, 1})}, T_truth_map, faces);
  EXPECT_EQ(doubled.duplicates, 1);
}

// A shelf 1.8 m high whose back is 7 cm before the wall, over 2 m of it: the plane of its back is no second plane of the wall, a plane on the wall
// behind it is, and so is one between the two that is mostly wall.
TEST(WallScore, FurnitureBeforeAWallIsNoDuplicate) {
  const auto faces = wall_faces(two_rooms(), poses({{2.5, 2}}));
  const std::vector<PlanBlock> shelf{{{2.0, 0.16, 0.9}, {2.0, 0.02, 1.8}, 0, false, true}};
  const ScenePlane on_wall = plane_on(0, {0.1, 0.1}, {4.9, 0.1}, {0, 1});
  const WallScore back = score_walls({on_wall, plane_on(1, {1, 0.17}, {3, 0.17}, {0, 1}, 0.005)}, T_truth_map, faces, shelf);
  EXPECT_EQ(back.duplicates, 0);
  EXPECT_EQ(back.other_planes, std::vector<std::int64_t>{1});
  EXPECT_EQ(score_walls({on_wall, plane_on(1, {1, 0.17}, {3, 0.17}, {0, 1})}, T_truth_map, faces).duplicates, 1) << "without the shelf";
  EXPECT_EQ(score_walls({on_wall, plane_on(1, {1, 0.1}, {3, 0.1}, {0, 1}, 0.02)}, T_truth_map, faces, shelf).duplicates, 1);
  EXPECT_EQ(score_walls({on_wall, plane_on(1, {1.5, 0.1}, {4.9, 0.1}, {0, 1}, 0.05)}, T_truth_map, faces, shelf).duplicates, 1);
}

// A pane is in the middle of its wall, 10 cm behind the face: what it reflects is no second plane of the wall.
TEST(WallScore, APaneIsNoDuplicate) {
  Plan plan = two_rooms();
  plan.walls[0].openings = {{2.0, 4.0, 0.1, 2.4, true}, {6.0, 7.0, 0, 2.1, false}};
  ASSERT_EQ(panes(plan).size(), 1u);
  const auto faces = wall_faces(plan, poses({{2.5, 2}}));
  const ScenePlane on_wall = plane_on(0, {0.1, 0.1}, {4.9, 0.1}, {0, 1});
  const ScenePlane on_pane = plane_on(1, {2.1, 0.1}, {3.9, 0.1}, {0, 1}, -0.095);
  EXPECT_EQ(score_walls({on_wall, on_pane}, T_truth_map, faces, panes(plan)).duplicates, 0);
  EXPECT_EQ(score_walls({on_wall, on_pane}, T_truth_map, faces).duplicates, 1) << "without the pane";
  EXPECT_EQ(score_walls({on_wall, plane_on(1, {2.1, 0.1}, {3.9, 0.1}, {0, 1}, -0.03)}, T_truth_map, faces, panes(plan)).duplicates, 1);
}

}  // namespace
}  // namespace sgraph
