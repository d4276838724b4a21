#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// Three keyframes on a storey and three elsewhere, half a metre apart, each of which sees a floor of 6 x 6 m: plane 0, and plane 1 of another storey
/// or the stairwell. `off`: how the map has the second three; `link`: standard deviations of the motion that led to them; `aside`: how far along x
/// their floor was seen.
struct TwoFloors {
  TwoFloors(const Pose& off, const Vector6& link, int second_storey, double aside = 0) {
    const Plane seen{Eigen::Vector3d::UnitZ(), 0.5};
    for (std::int64_t k = 0; k < 6; ++k) {
      const KeyframeId id{k};
      const PlaneId plane{k / 3};
      const double shift = k < 3 ? 0 : aside;
      const Outline floor{{shift - 3, -3, -0.5}, {shift + 3, -3, -0.5}, {shift + 3, 3, -0.5}, {shift - 3, 3, -0.5}};
      Pose pose{Eigen::Quaterniond::Identity(), {0.5 * static_cast<double>(k), 0, 0}};
      if (k >= 3) pose = {off.rotation, pose.translation + off.translation};
      Transaction edit;
      edit.keyframes[id] = pose;
      if (k % 3 == 0) edit.planes[plane] = pose * seen;
      if (k > 0) {
        const Pose& before = *graph.find(KeyframeId{k - 1});
        const Vector6 sigma = k == 3 ? link : Vector6::Constant(0.001);
        add_factor(edit, Se3Between{{k - 1}, id, before.inverse() * pose, SqrtInformation<6>::from_std_dev(sigma)});
      }
      add_factor(edit, PosePlane{id, plane, seen, {}, SqrtInformation<3>::from_std_dev({0.003, 0.003, 0.006})});
      const Applied applied = committer.commit(edit);
      EXPECT_TRUE(applied.ok()) << applied.detail;
      planes.observe(graph, plane, id, applied.factors.back(), floor, {}, seen, 1e-5 * Eigen::Matrix3d::Identity());
      planes.reclassify(graph, plane, {});
      if (k % 3 == 0) planes.set_storey(plane, k == 0 ? 0 : second_storey);
    }
  }

  TwoFloors(const TwoFloors&) = delete;  // the committer knows this graph
  TwoFloors& operator=(const TwoFloors&) = delete;

  double tilt() const { return std::acos(graph.find(PlaneId{0})->normal.dot(graph.find(PlaneId{1})->normal)); }
  double step() const { return graph.find(PlaneId{0})->d - graph.find(PlaneId{1})->d; }

  Graph graph;
  DecisionLog log;
  Committer committer{graph, log};
  PlaneMap planes{SemanticsParams{}};
};

}  // namespace sgraph
