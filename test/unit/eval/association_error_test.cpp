#include "sgraph_slam/core/eval/association_error.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

// A wall of two thicknesses in one line: faces at y = 0.1 (x from 0 to 5) and y = 0.15 (from 5 to 10).
std::vector<WallFace> two_faces() {
  std::vector<WallFace> faces(2);
  faces[0].begin = {0, 0.1};
  faces[0].end = {5, 0.1};
  faces[1].begin = {5, 0.15};
  faces[1].end = {10, 0.15};
  for (WallFace& face : faces) {
    face.normal = {0, 1};
    face.seen_length = face.length();
  }
  return faces;
}

const Pose T_truth_map = se3_exp((Vector6() << 0, 0, 0.7, 2, -1, 0).finished());

ScenePlane mapped(std::int64_t id, double y, double low, double high) {
  ScenePlane plane;
  plane.id = {id};
  plane.plane = T_truth_map.inverse() * Plane{Eigen::Vector3d::UnitY(), -y};
  for (const auto& [x, z] : {std::pair{low, 0.0}, {high, 0.0}, {high, 2.5}, {low, 2.5}})
    plane.extent.push_back(T_truth_map.inverse() * Eigen::Vector3d(x, y, z));
  return plane;
}

TEST(AssociationScore, CountsObservationsOfAnotherFaceAndOfDuplicates) {
  Trajectory truth;
  std::vector<AssociatedPlane> observations;
  const auto observe = [&](std::int64_t plane, double y, double x) {
    const Stamp stamp = Stamp::from_seconds(1.0 + static_cast<double>(truth.size()));
    truth.push_back({stamp, se3_exp((Vector6() << 0, 0, 0.3 * x, x, 2, 0.3).finished())});
    observations.push_back({stamp, plane, truth.back().pose.inverse() * Plane{Eigen::Vector3d::UnitY(), -y}});
  };
  for (int i = 0; i < 6; ++i) observe(0, 0.1 + 0.002 * i, 0.5 + 0.5 * i);
  for (int i = 0; i < 5; ++i) observe(1, 0.15, 6 + 0.5 * i);
  observe(0, 0.148, 6);  // taken for the thinner wall
  observe(2, 0.105, 2);  // a second plane on the first face
  observe(7, 1.4, 3);    // a cupboard's front
  const std::vector<ScenePlane> planes{mapped(0, 0.1, 0, 5), mapped(1, 0.15, 5, 10), mapped(2, 0.104, 1, 3), mapped(7, 1.4, 2, 4)};
  const auto faces = two_faces();
  const WallScore walls = score_walls(planes, T_truth_map, faces);
  ASSERT_EQ(walls.duplicates, 1);
  const AssociationScore score = score_associations(observations, planes, truth, T_truth_map, faces, walls);
  EXPECT_EQ(score.observations, 13);
  EXPECT_EQ(score.wrong_face, 1);
  EXPECT_EQ(score.split, 1);
  EXPECT_NEAR(score.right_share(), 11.0 / 13, 1e-12);
}

}  // namespace
}  // namespace sgraph
