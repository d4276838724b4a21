#include "sgraph_slam/core/graph/factors/se3_between.hpp"

#include "sgraph_slam/core/math/se3.hpp"
#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class Se3BetweenCost final : public TangentCost<Se3BetweenCost, 6, PoseBlock, PoseBlock> {
 public:
  explicit Se3BetweenCost(const Se3Between& factor) : T_to_from_(factor.T_from_to.inverse()), weight_(factor.weight.matrix()) {}

  void evaluate(const Pose& from, const Pose& to, Residual& e, Jacobians* jacobians) const {
    const Pose T_from_to = from.inverse() * to;
    const Vector6 error = se3_log(T_to_from_ * T_from_to);
    e.noalias() = weight_ * error;
    if (jacobians == nullptr) return;
    auto& [by_from, by_to] = *jacobians;
    by_to.noalias() = weight_ * se3_right_jacobian_inverse(error);
    by_from.noalias() = -by_to * se3_adjoint(T_from_to.inverse());
  }

 private:
  Pose T_to_from_;
  Matrix6 weight_;
};

}  // namespace

CostPtr make_cost(const Se3Between& factor) { return std::make_unique<Se3BetweenCost>(factor); }

}  // namespace sgraph
