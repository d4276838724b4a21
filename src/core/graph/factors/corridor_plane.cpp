#include "sgraph_slam/core/graph/factors/corridor_plane.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class CorridorPlaneCost final : public TangentCost<CorridorPlaneCost, 1, CorridorBlock, PlaneBlock> {
 public:
  CorridorPlaneCost(const CorridorPlane& factor, const Corridor& corridor)
      : across_(corridor.across()), origin_(corridor.along * corridor.direction() + Eigen::Vector3d(0, 0, corridor.z)), weight_(1.0 / factor.sigma) {}

  void evaluate(const Eigen::Vector2d& corridor, const Plane& plane, Residual& e, Jacobians* jacobians) const {
    const Eigen::Vector3d center = origin_ + corridor[0] * across_;
    e[0] = weight_ * (plane.distance(center) - 0.5 * corridor[1]);
    if (jacobians == nullptr) return;
    auto& [by_corridor, by_plane] = *jacobians;
    by_corridor << weight_ * plane.normal.dot(across_), -0.5 * weight_;
    by_plane << weight_ * center.transpose() * tangent_basis(plane.normal), weight_;
  }

 private:
  Eigen::Vector3d across_;
  Eigen::Vector3d origin_;  // of the centre line at the map's origin across
  double weight_;
};

}  // namespace

CostPtr make_cost(const CorridorPlane& factor, const Corridor& corridor) { return std::make_unique<CorridorPlaneCost>(factor, corridor); }

}  // namespace sgraph
