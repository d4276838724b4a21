#include "plane_observation.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class PlaneObservationCost final : public TangentCost<PlaneObservationCost, 3, PoseBlock, PlaneBlock> {
 public:
  explicit PlaneObservationCost(const PlaneObservation& observation) : observation_(observation) {}

  void evaluate(const Pose& T_map_base, const Plane& plane, Residual& e, Jacobians* jacobians) const {
    observation_.evaluate(T_map_base.matrix(), T_map_base.translation, plane.normal, plane.d, tangent_basis(plane.normal), e,
                          jacobians == nullptr ? nullptr : &std::get<0>(*jacobians), jacobians == nullptr ? nullptr : &std::get<1>(*jacobians));
  }

 private:
  PlaneObservation observation_;
};

}  // namespace

PlaneObservation PlaneObservation::in_lidar(const Eigen::Matrix<double, 3, 4>& A, const Eigen::Vector3d& b, const Pose& T_base_lidar) {
  // n_lidar = R_bl^T n_base, d_lidar = d_base + t_bl . n_base
  PlaneObservation out{A, b};
  out.A.leftCols<3>() = A.leftCols<3>() * T_base_lidar.matrix().transpose() + A.col(3) * T_base_lidar.translation.transpose();
  return out;
}

PlaneObservation PlaneObservation::of(const PosePlane& factor) {
  Eigen::Matrix<double, 3, 4> tangent = Eigen::Matrix<double, 3, 4>::Zero();
  tangent.topLeftCorner<2, 3>() = tangent_basis(factor.measured.normal).transpose();
  tangent(2, 3) = 1.0;
  return in_lidar(factor.weight.matrix() * tangent, factor.weight.matrix().col(2) * factor.measured.d, factor.T_base_lidar);
}

PlaneObservation PlaneObservation::of(const PosePlanePoints& factor) { return in_lidar(factor.points, Eigen::Vector3d::Zero(), factor.T_base_lidar); }

CostPtr make_cost(const PlaneObservation& observation) { return std::make_unique<PlaneObservationCost>(observation); }

}  // namespace sgraph
