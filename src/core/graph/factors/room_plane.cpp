#include "sgraph_slam/core/graph/factors/room_plane.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class RoomPlaneCost final : public TangentCost<RoomPlaneCost, 1, RoomBlock, PlaneBlock> {
 public:
  RoomPlaneCost(const RoomPlane& factor, const Room& room) : axis_(axis_of(factor.side)), z_(room.z), weight_(1.0 / factor.sigma) {
    axes_ << room.axis(0), room.axis(1);
  }

  void evaluate(const Eigen::Vector4d& room, const Plane& plane, Residual& e, Jacobians* jacobians) const {
    const Eigen::Vector3d center = axes_ * room.head<2>() + Eigen::Vector3d(0, 0, z_);
    e[0] = weight_ * (plane.distance(center) - 0.5 * room[2 + axis_]);
    if (jacobians == nullptr) return;
    auto& [by_room, by_plane] = *jacobians;
    by_room << weight_ * plane.normal.transpose() * axes_, 0.0, 0.0;
    by_room[2 + axis_] = -0.5 * weight_;
    by_plane << weight_ * center.transpose() * tangent_basis(plane.normal), weight_;
  }

 private:
  Eigen::Matrix<double, 3, 2> axes_;
  int axis_;
  double z_;
  double weight_;
};

}  // namespace

CostPtr make_cost(const RoomPlane& factor, const Room& room) { return std::make_unique<RoomPlaneCost>(factor, room); }

}  // namespace sgraph
