#include "sgraph_slam/core/graph/factors/corridor_width.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class CorridorWidthCost final : public TangentCost<CorridorWidthCost, 1, CorridorBlock> {
 public:
  explicit CorridorWidthCost(const CorridorWidth& factor) : measured_(factor.measured), weight_(1.0 / factor.sigma) {}

  void evaluate(const Eigen::Vector2d& corridor, Residual& e, Jacobians* jacobians) const {
    e[0] = weight_ * (corridor[1] - measured_);
    if (jacobians != nullptr) std::get<0>(*jacobians) << 0.0, weight_;
  }

 private:
  double measured_;
  double weight_;
};

}  // namespace

CostPtr make_cost(const CorridorWidth& factor) { return std::make_unique<CorridorWidthCost>(factor); }

}  // namespace sgraph
