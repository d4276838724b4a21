#include "plane_observation.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class PlaneObservationCost final : public TangentCost<PlaneObservationCost, 3, PoseBlock, PlaneBlock> {
 public:
  PlaneObservationCost(const Eigen::Matrix<double, 3, 4>& A, const Eigen::Vector3d& b, const Pose& T_base_lidar)
      : A_(A), b_(b), R_base_lidar_(T_base_lidar.matrix()), t_base_lidar_(T_base_lidar.translation) {}

  void evaluate(const Pose& T_map_base, const Plane& plane, Residual& e, Jacobians* jacobians) const {
    const Eigen::Matrix3d R = T_map_base.matrix();
    const Eigen::Vector3d n_base = R.transpose() * plane.normal;
    Eigen::Vector4d pi_lidar;
    pi_lidar << R_base_lidar_.transpose() * n_base, plane.d + T_map_base.translation.dot(plane.normal) + t_base_lidar_.dot(n_base);
    e.noalias() = A_ * pi_lidar - b_;
    if (jacobians == nullptr) return;

    Eigen::Matrix<double, 4, 3> by_n_base;  // pi_lidar by the normal in the base frame
    by_n_base << R_base_lidar_.transpose(), t_base_lidar_.transpose();
    const Eigen::Matrix<double, 3, 3> A_by_n = A_ * by_n_base;
    const Eigen::Vector3d A_by_d = A_.col(3);
    auto& [by_pose, by_plane] = *jacobians;
    by_pose.leftCols<3>().noalias() = A_by_n * skew(n_base);  // R exp(phi): n_base + n_base x phi
    by_pose.rightCols<3>().noalias() = A_by_d * n_base.transpose();
    const Eigen::Matrix<double, 3, 2> basis = tangent_basis(plane.normal);
    by_plane.leftCols<2>().noalias() = A_by_n * (R.transpose() * basis) + A_by_d * (T_map_base.translation.transpose() * basis);
    by_plane.rightCols<1>() = A_by_d;
  }

 private:
  Eigen::Matrix<double, 3, 4> A_;
  Eigen::Vector3d b_;
  Eigen::Matrix3d R_base_lidar_;
  Eigen::Vector3d t_base_lidar_;
};

}  // namespace

CostPtr make_plane_observation(const Eigen::Matrix<double, 3, 4>& A, const Eigen::Vector3d& b, const Pose& T_base_lidar) {
  return std::make_unique<PlaneObservationCost>(A, b, T_base_lidar);
}

}  // namespace sgraph
