#include "sgraph_slam/core/eval/association_error.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/eval/trajectory_error.hpp"
#include "sgraph_slam/core/eval/true_associations.hpp"
#include "sgraph_slam/core/graph/serialization.hpp"
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

// A robot along the two faces, both taken for one plane by the mapping; a wall across and the floor hold the rest.
TEST(TrueAssociations, UndoWhatWrongOnesCost) {
  const std::vector<WallFace> faces = two_faces();
  const Plane across{-Eigen::Vector3d::UnitX(), 10};
  const Plane floor{Eigen::Vector3d::UnitZ(), 0};
  GraphSnapshot snapshot;
  Trajectory truth;
  Graph graph;
  Transaction edit;
  const auto weight = [](double sigma) {
    return SqrtInformation<3>::from_covariance(sigma * sigma * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Constant(1e-9));
  };
  for (int i = 0; i < 20; ++i) {
    const Pose T_truth_base = se3_exp((Vector6() << 0, 0, 0.2 * std::sin(i), 0.5 * i, 2, 0).finished());
    const KeyframeId id{i};
    truth.push_back({Stamp::from_seconds(i + 1.0), T_truth_base});
    edit.keyframes[id] = T_truth_map.inverse() * T_truth_base;
    const Plane face{Eigen::Vector3d::UnitY(), T_truth_base.translation.x() < 5 ? -0.1 : -0.15};
    for (const auto& [plane, seen] : {std::pair{0, face}, {1, across}, {2, floor}})
      edit.factors.push_back({PosePlane{id, {plane}, T_truth_base.inverse() * seen, Pose{}, weight(0.005)}, {}});
    if (i == 0) continue;
    const Pose step = truth[static_cast<std::size_t>(i) - 1].pose.inverse() * T_truth_base;
    Eigen::Matrix<double, 6, 6> covariance = 4e-4 * Eigen::Matrix<double, 6, 6>::Identity();
    edit.factors.push_back({Se3Between{{i - 1}, id, step, SqrtInformation<6>::from_covariance(covariance, Vector6::Constant(1e-9))}, {}});
  }
  snapshot.planes[{0}] = mapped(0, 0.12, 0, 10);
  snapshot.planes[{1}].plane = T_truth_map.inverse() * across;
  snapshot.planes[{2}].plane = T_truth_map.inverse() * floor;
  std::vector<ScenePlane> planes;
  for (auto& [id, plane] : snapshot.planes) {
    plane.id = id;
    edit.planes[id] = plane.plane;
    planes.push_back(plane);
  }
  ASSERT_TRUE(graph.apply(edit).ok());
  snapshot.factors_json = factors_to_json(graph);
  for (const auto& [id, pose] : graph.keyframes()) {
    snapshot.keyframes[id].id = id;
    snapshot.keyframes[id].stamp = truth[static_cast<std::size_t>(id.value)].stamp;
    snapshot.keyframes[id].T_map_base = pose;
  }
  const auto study = with_true_associations(snapshot, truth, T_truth_map, faces, score_walls(planes, T_truth_map, faces));
  ASSERT_TRUE(study);
  const auto error = [&](const Trajectory& poses) {
    const auto pairs = pair_by_stamp(poses, truth);
    return statistics_of(absolute_errors(pairs, align(pairs))).translation.rmse;
  };
  EXPECT_GT(error(study->mapped), 0.008);
  EXPECT_LT(error(study->corrected), 1e-4);
}

}  // namespace
}  // namespace sgraph
