#include <ceres/autodiff_cost_function.h>
#include <ceres/dynamic_autodiff_cost_function.h>
#include <ceres/gradient_checker.h>
#include <ceres/manifold.h>
#include <ceres/product_manifold.h>
#include <ceres/sphere_manifold.h>
#include <gtest/gtest.h>

#include "factor_cases.hpp"
#include "factor_reference.hpp"
#include "sgraph_slam/core/graph/solver.hpp"

namespace sgraph::test {
namespace {

constexpr int points_each = 300;
constexpr double tolerance = 1e-6;  // of Jacobians, relative; Ceres' own sphere is good to 1e-9 beside its pole, times weights of some hundreds

// The variables of a case as Ceres takes them.
struct Parameters {
  explicit Parameters(const FactorCase& c) {
    for (const VariableId& id : blocks(c.factor.data)) {
      if (const auto* keyframe = std::get_if<KeyframeId>(&id)) {
        const Pose& pose = *c.graph.find(*keyframe);
        const Eigen::Vector4d q = pose.rotation.coeffs();
        values.push_back({q[0], q[1], q[2], q[3], pose.translation[0], pose.translation[1], pose.translation[2]});
        manifolds.push_back(&pose_manifold);
      } else if (const auto* plane_id = std::get_if<PlaneId>(&id)) {
        const Plane& plane = *c.graph.find(*plane_id);
        values.push_back({plane.normal[0], plane.normal[1], plane.normal[2], plane.d});
        manifolds.push_back(&plane_manifold);
      } else if (const auto* room_id = std::get_if<RoomId>(&id)) {
        const Room& room = *c.graph.find(*room_id);
        values.push_back({room.position[0], room.position[1], room.width[0], room.width[1]});
        manifolds.push_back(&room_manifold);
      } else {
        const Corridor& corridor = *c.graph.find(std::get<CorridorId>(id));
        values.push_back({corridor.position, corridor.width});
        manifolds.push_back(&corridor_manifold);
      }
    }
    for (const auto& v : values) pointers.push_back(v.data());
  }

  ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>> pose_manifold;
  ceres::ProductManifold<ceres::SphereManifold<3>, ceres::EuclideanManifold<1>> plane_manifold;
  ceres::EuclideanManifold<4> room_manifold;
  ceres::EuclideanManifold<2> corridor_manifold;
  std::vector<std::vector<double>> values;
  std::vector<const double*> pointers;
  std::vector<const ceres::Manifold*> manifolds;
};

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Residual and Jacobians along the manifold.
struct Linearised {
  Eigen::VectorXd residual;
  std::vector<Eigen::MatrixXd> jacobians;
};

Linearised linearised(const ceres::CostFunction& cost, const Parameters& x) {
  Linearised out;
  out.residual.resize(cost.num_residuals());
  std::vector<RowMajor> ambient;
  std::vector<double*> data;
  for (const auto& v : x.values) ambient.emplace_back(cost.num_residuals(), v.size());
  for (auto& j : ambient) data.push_back(j.data());
  EXPECT_TRUE(cost.Evaluate(x.pointers.data(), out.residual.data(), data.data()));
  for (std::size_t i = 0; i < ambient.size(); ++i) {
    RowMajor plus(x.manifolds[i]->AmbientSize(), x.manifolds[i]->TangentSize());
    x.manifolds[i]->PlusJacobian(x.pointers[i], plus.data());
    out.jacobians.emplace_back(ambient[i] * plus);
  }
  return out;
}

class EachFactor : public testing::TestWithParam<int> {};

TEST_P(EachFactor, JacobiansAgreeWithNumericDifferences) {
  Draw draw(static_cast<unsigned>(100 + GetParam()));
  for (int i = 0; i < points_each; ++i) {
    const FactorCase c = random_case(draw, GetParam());
    const auto cost = cost_of(c);
    const Parameters x(c);
    ceres::NumericDiffOptions steps;
    steps.ridders_relative_initial_step_size = 1e-3;  // the default of 1e-2 leaves the quaternion's neighbourhood
    ceres::GradientChecker checker(cost.get(), &x.manifolds, steps);
    ceres::GradientChecker::ProbeResults results;
    checker.Probe(x.pointers.data(), 1e-6, &results);  // its own verdict is by entry, and entries that are zero have no relative error
    ASSERT_TRUE(results.return_value);
    for (std::size_t k = 0; k < x.values.size(); ++k) {
      const ceres::Matrix difference = results.local_jacobians[k] - results.local_numeric_jacobians[k];
      ASSERT_LT(difference.norm(), tolerance * (1 + results.local_jacobians[k].norm())) << "point " << i << " block " << k;
    }
  }
}

TEST_P(EachFactor, AgreesWithItsEquationDifferentiatedAutomatically) {
  Draw draw(static_cast<unsigned>(200 + GetParam()));
  for (int i = 0; i < points_each; ++i) {
    const FactorCase c = random_case(draw, GetParam());
    const Parameters x(c);
    ceres::DynamicAutoDiffCostFunction<FactorReference, 7> reference(
        new FactorReference{c.factor.data, *c.graph.find(RoomId{0}), *c.graph.find(CorridorId{0})});
    for (const auto& v : x.values) reference.AddParameterBlock(static_cast<int>(v.size()));
    reference.SetNumResiduals(residual_size(c.factor.data));
    const Linearised wanted = linearised(reference, x);
    const Linearised got = linearised(*cost_of(c), x);
    ASSERT_LT((got.residual - wanted.residual).norm(), 1e-8 * (1 + wanted.residual.norm())) << "point " << i;
    for (std::size_t k = 0; k < x.values.size(); ++k) {
      ASSERT_LT((got.jacobians[k] - wanted.jacobians[k]).norm(), tolerance * (1 + wanted.jacobians[k].norm())) << "point " << i << " block " << k;
    }
  }
}

// The case seen from a world frame moved by T (level: rooms and corridors stand upright).
FactorCase moved(const FactorCase& c, const Pose& T, double yaw) {
  FactorCase out = c;
  for (const auto& [id, pose] : c.graph.keyframes()) out.graph.set(id, T * pose);
  for (const auto& [id, plane] : c.graph.planes()) out.graph.set(id, Plane(T * plane));
  for (const auto& [id, room] : c.graph.rooms()) out.graph.set(id, Room::at(T * room.center(), room.yaw + yaw, room.width));
  for (const auto& [id, corridor] : c.graph.corridors()) out.graph.set(id, Corridor::at(T * corridor.center(), corridor.yaw + yaw, corridor.width));
  if (auto* thickness = std::get_if<WallThickness>(&out.factor.data)) thickness->point = T * thickness->point;
  if (auto* aligned = std::get_if<AlignedWalls>(&out.factor.data)) {
    aligned->from = T * aligned->from;
    aligned->to = T * aligned->to;
  }
  if (auto* known = std::get_if<PlanePrior>(&out.factor.data)) {  // the prior moves with the map; its weight belongs to another tangent basis then
    const Eigen::Matrix<double, 3, 2> basis = T.matrix() * tangent_basis(known->prior.normal);
    known->prior = T * known->prior;
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = basis.transpose() * tangent_basis(known->prior.normal);
    known->weight = SqrtInformation<3>::from_factor(known->weight.matrix() * turn);
  }
  return out;
}

TEST_P(EachFactor, DoesntChangeWhenTheWorldMoves) {
  const bool upright = GetParam() == 7 || GetParam() == 8 || GetParam() == 11;
  Draw draw(static_cast<unsigned>(300 + GetParam()));
  for (int i = 0; i < points_each; ++i) {
    const FactorCase c = random_case(draw, GetParam());
    const double yaw = draw.uniform(-M_PI, M_PI);
    Pose level{so3_exp(Eigen::Vector3d(0, 0, yaw)), draw.normals<3>(30.0)};
    if (GetParam() == 3) level.translation.setZero();  // a prior's d is the distance from the map's own origin
    const FactorCase d = moved(c, upright ? level : level * Pose{so3_exp(draw.normals<3>()), Eigen::Vector3d::Zero()}, yaw);
    const Eigen::VectorXd before = weighted_residual(c.graph, c.factor.data);
    const Eigen::VectorXd after = weighted_residual(d.graph, d.factor.data);
    if (std::holds_alternative<ParallelPlanes>(c.factor.data)) {  // a vector in the map's frame
      ASSERT_NEAR(before.norm(), after.norm(), 1e-8);
    } else {
      ASSERT_LT((before - after).norm(), 1e-8 * (1 + before.norm())) << "point " << i;
    }
  }
}

TEST_P(EachFactor, IsFiniteEverywhere) {
  Draw draw(static_cast<unsigned>(400 + GetParam()));
  for (int i = 0; i < points_each; ++i) {
    FactorCase c = random_case(draw, GetParam());
    // Far from every measurement: opposite and orthogonal planes, half turns, far away.
    const Pose turned = *c.graph.find(KeyframeId{0}) * Pose{so3_exp(M_PI * draw.direction()), draw.normals<3>(1e3)};
    c.graph.set(KeyframeId{i % 2}, turned);
    const Plane plane = *c.graph.find(PlaneId{0});
    const Eigen::Vector3d normal = i % 3 == 0 ? -plane.normal : i % 3 == 1 ? Eigen::Vector3d(tangent_basis(plane.normal).col(0)) : plane.normal;
    c.graph.set(PlaneId{0}, Plane{normal, 1e6 * draw.normal()});
    const Linearised all = linearised(*cost_of(c), Parameters(c));
    ASSERT_TRUE(all.residual.allFinite());
    for (const auto& j : all.jacobians) ASSERT_TRUE(j.allFinite());
  }
}

TEST_P(EachFactor, IsZeroWithItsMeasurementFulfilled) {
  Draw draw(static_cast<unsigned>(500 + GetParam()));
  const Pose T_base_lidar{so3_exp(Eigen::Vector3d(0.1, -0.2, 3.1)), {0.2, -0.1, 0.5}};
  for (int i = 0; i < 50; ++i) {
    Graph graph = random_case(draw, 4).graph;
    const Pose a = *graph.find(KeyframeId{0});
    const Plane p = *graph.find(PlaneId{0});
    const Plane seen = (a * T_base_lidar).inverse() * p;
    Room room = *graph.find(RoomId{0});
    Corridor corridor = *graph.find(CorridorId{0});
    const PlaneId wall{1};
    FactorData factor;
    switch (GetParam()) {
      case 0: factor = Se3Between{{0}, {1}, a.inverse() * *graph.find(KeyframeId{1}), draw.weight<6>()}; break;
      case 1: factor = PosePlane{{0}, {0}, seen, T_base_lidar, draw.weight<3>()}; break;
      case 2: factor = PosePlanePoints{{0}, {0}, sqrt_scatter(draw.scatter(seen, 0.0), 0.02, 1e-4, 1e-3), T_base_lidar}; break;
      case 3: factor = PlanePrior{{0}, p, draw.weight<3>()}; break;
      case 4: graph.set(wall, Plane{-p.normal, 3.0}), factor = ParallelPlanes{{0}, wall}; break;
      case 5: graph.set(wall, Plane{tangent_basis(p.normal).col(0), 3.0}), factor = PerpendicularPlanes{{0}, wall}; break;
      case 6: graph.set(wall, Plane{-p.normal, -0.2 - p.d}), factor = WallThickness{{0}, wall, 0.2, 0.01, draw.normals<3>()}; break;
      case 7: {  // the paper's form: low side s = -d, high side s = d
        const double s = room.position.y() + 0.5 * room.width.y();
        graph.set(wall, Plane{-room.axis(1), s}), factor = RoomPlane{{0}, wall, RoomSide::y_high};
        break;
      }
      case 8: {
        const double s = corridor.position - 0.5 * corridor.width;
        graph.set(wall, Plane{corridor.across(), -s}), factor = CorridorPlane{{0}, wall, CorridorSide::right};
        break;
      }
      case 9: factor = RoomWidth{{0}, {0}, 1, room.width.y()}; break;
      case 10: factor = CorridorWidth{{0}, {0}, corridor.width}; break;
      default: {
        const Eigen::Vector3d at = draw.normals<3>();
        const Eigen::Vector3d up(0, 0, 3);
        graph.set(wall, Plane{p.normal, p.d - p.normal.dot(up)});
        factor = AlignedWalls{{0}, wall, at, at + 4 * tangent_basis(p.normal).col(0), 3, 0.01, 0.02};
        break;
      }
    }
    ASSERT_LT(weighted_residual(graph, factor).norm(), 1e-6);
  }
}

std::string kind_name(const testing::TestParamInfo<int>& info) {
  Draw draw(1);
  return type_name(random_factor(draw, info.param, random_case(draw, 4).graph)) + std::string(info.param == 0 ? "_or_loop" : "");
}
INSTANTIATE_TEST_SUITE_P(Factors, EachFactor, testing::Range(0, factor_kinds), kind_name);

TEST(PosePlanePoints, CostIsTheSumOfSquaredDistancesLessItsLeast) {
  Draw draw(11);
  const double sigma = 0.02;
  for (int i = 0; i < 200; ++i) {
    const Plane truth{draw.direction(), draw.uniform(0.3, 8.0)};
    const Eigen::Matrix4d scatter = draw.scatter(truth, 0.02);
    const SqrtScatter root = sqrt_scatter(scatter, sigma, 1e-6, 1e-6);  // floors that don't bind
    const auto sum = [&](const Plane& p) {
      const Eigen::Vector4d pi(p.normal[0], p.normal[1], p.normal[2], p.d);
      return pi.dot(scatter * pi) / (sigma * sigma);
    };
    const auto form = [&](const Plane& p) { return (root * Eigen::Vector4d(p.normal[0], p.normal[1], p.normal[2], p.d)).squaredNorm(); };
    const Plane a = draw.near(truth, 0.05, 0.1);
    const Plane b = draw.near(truth, 0.05, 0.1);
    EXPECT_NEAR(sum(a) - sum(b), form(a) - form(b), 1e-6 * sum(a));
    EXPECT_GE(form(a), 0.0);
  }
}

TEST(PosePlanePoints, InformationIsBoundedAndTheFitStaysTheMinimum) {
  Draw draw(12);
  const double floor_angle = 0.003;
  const double floor_distance = 0.01;
  for (int i = 0; i < 200; ++i) {
    const Plane truth{draw.direction(), draw.uniform(0.3, 8.0)};
    const SqrtScatter root = sqrt_scatter(draw.scatter(truth, 0.0, 5000), 0.02, floor_angle, floor_distance);
    const auto form = [&](const Plane& p) { return (root * Eigen::Vector4d(p.normal[0], p.normal[1], p.normal[2], p.d)).squaredNorm(); };
    EXPECT_NEAR(form(truth), 0.0, 1e-6);
    const Plane off{truth.normal, truth.d + 0.1};
    EXPECT_LE(form(off), 0.1 * 0.1 / (floor_distance * floor_distance) * (1 + 1e-9));
    EXPECT_GT(form(off), 0.0);
    const Eigen::Vector3d step = tangent_basis(truth.normal) * Eigen::Vector2d(0.01, 0.0);
    const Eigen::Vector4d tilt(step[0], step[1], step[2], 0.0);
    EXPECT_LE((root * tilt).squaredNorm(), 0.01 * 0.01 / (floor_angle * floor_angle) * (1 + 1e-9));
  }
}

TEST(PosePlanePoints, AStripeHoldsOnlyWhatItHolds) {
  // Points on one line: the plane may turn about it freely.
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  for (int i = -20; i <= 20; ++i) {
    const Eigen::Vector4d p(2.0, 0.1 * i, 0.5, 1.0);
    scatter += p * p.transpose();
  }
  const SqrtScatter root = sqrt_scatter(scatter, 0.02, 0.001, 0.005);
  for (const double angle : {-0.5, 0.0, 0.3, 1.0}) {
    const Eigen::Vector3d n(-std::cos(angle), 0.0, std::sin(angle));
    const double d = -n.dot(Eigen::Vector3d(2.0, 0.0, 0.5));
    EXPECT_NEAR((root * Eigen::Vector4d(n[0], n[1], n[2], d)).norm(), 0.0, 1e-5);
    EXPECT_GT((root * Eigen::Vector4d(n[0], n[1], n[2], d + 0.05)).norm(), 1.0);
  }
}

TEST(PosePlanePoints, BadScatterIsNotFiniteAndSoRefused) {
  EXPECT_FALSE(sqrt_scatter(Eigen::Matrix4d::Zero(), 0.02, 0.001, 0.005).allFinite());
  EXPECT_FALSE(sqrt_scatter(Eigen::Matrix4d::Constant(std::nan("")), 0.02, 0.001, 0.005).allFinite());
  EXPECT_FALSE(sqrt_scatter(Eigen::Matrix4d::Identity(), 0.0, 0.001, 0.005).allFinite());
}

TEST(SqrtInformation, ASigmaIsASigma) {
  Draw draw(21);
  const auto w = SqrtInformation<3>::from_std_dev({0.1, 0.2, 0.5});
  EXPECT_NEAR((w.matrix() * Eigen::Vector3d(0.1, 0.2, 0.5) - Eigen::Vector3d::Ones()).norm(), 0.0, 1e-12);
  for (int i = 0; i < 100; ++i) {
    const Matrix6 covariance = draw.covariance<6>(0.1);
    const auto weight = SqrtInformation<6>::from_covariance(covariance, Vector6::Constant(1e-9));
    EXPECT_LT((weight.information() * covariance - Matrix6::Identity()).norm(), 1e-6);
    EXPECT_LT((SqrtInformation<6>::from_information(covariance.inverse()).matrix() - weight.matrix()).norm(), 1e-6 * weight.matrix().norm());
    EXPECT_TRUE(weight.matrix().isUpperTriangular(0.0));
  }
}

TEST(SqrtInformation, FloorsBoundAnyCovariance) {
  const Vector6 floors = (Vector6() << 0.01, 0.01, 0.01, 0.1, 0.1, 0.1).finished();
  const auto none = SqrtInformation<6>::from_covariance(Matrix6::Zero(), floors);
  EXPECT_LT((none.matrix() - SqrtInformation<6>::from_std_dev(floors).matrix()).norm(), 1e-9);
  Matrix6 indefinite = Matrix6::Zero();
  indefinite(0, 1) = indefinite(1, 0) = 1.0;
  const auto weight = SqrtInformation<6>::from_covariance(indefinite, floors);
  for (int k = 0; k < 6; ++k) EXPECT_LE(weight.matrix().col(k).norm(), 1.0 / floors[k] * (1 + 1e-9));
  EXPECT_FALSE(SqrtInformation<6>::from_covariance(Matrix6::Constant(std::nan("")), floors).matrix().allFinite());
}

}  // namespace
}  // namespace sgraph::test
