#include "sgraph_slam/core/graph/factors/room_width.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class RoomWidthCost final : public TangentCost<RoomWidthCost, 1, RoomBlock> {
 public:
  explicit RoomWidthCost(const RoomWidth& factor) : axis_(factor.axis), measured_(factor.measured), weight_(1.0 / factor.sigma) {}

  void evaluate(const Eigen::Vector4d& room, Residual& e, Jacobians* jacobians) const {
    e[0] = weight_ * (room[2 + axis_] - measured_);
    if (jacobians != nullptr) std::get<0>(*jacobians) = weight_ * Eigen::RowVector4d::Unit(2 + axis_);
  }

 private:
  int axis_;
  double measured_;
  double weight_;
};

}  // namespace

CostPtr make_cost(const RoomWidth& factor) { return std::make_unique<RoomWidthCost>(factor); }

}  // namespace sgraph
