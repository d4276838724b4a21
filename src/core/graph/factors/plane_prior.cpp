#include "sgraph_slam/core/graph/factors/plane_prior.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class PlanePriorCost final : public TangentCost<PlanePriorCost, 3, PlaneBlock> {
 public:
  explicit PlanePriorCost(const PlanePrior& factor)
      : prior_(factor.prior), basis_(tangent_basis(factor.prior.normal)), weight_(factor.weight.matrix()) {}

  void evaluate(const Plane& plane, Residual& e, Jacobians* jacobians) const {
    Eigen::Vector3d difference;
    difference << basis_.transpose() * plane.normal, plane.d - prior_.d;
    e.noalias() = weight_ * difference;
    if (jacobians == nullptr) return;
    Eigen::Matrix3d j = Eigen::Matrix3d::Identity();
    j.topLeftCorner<2, 2>().noalias() = basis_.transpose() * tangent_basis(plane.normal);
    std::get<0>(*jacobians).noalias() = weight_ * j;
  }

 private:
  Plane prior_;
  Eigen::Matrix<double, 3, 2> basis_;
  Eigen::Matrix3d weight_;
};

}  // namespace

CostPtr make_cost(const PlanePrior& factor) { return std::make_unique<PlanePriorCost>(factor); }

}  // namespace sgraph
