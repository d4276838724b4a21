#include "sgraph_slam/core/graph/factors/wall_thickness.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class WallThicknessCost final : public TangentCost<WallThicknessCost, 1, PlaneBlock, PlaneBlock> {
 public:
  explicit WallThicknessCost(const WallThickness& factor) : point_(factor.point), thickness_(factor.thickness), weight_(1.0 / factor.sigma) {}

  void evaluate(const Plane& a, const Plane& b, Residual& e, Jacobians* jacobians) const {
    e[0] = weight_ * (-a.distance(point_) - b.distance(point_) - thickness_);
    if (jacobians == nullptr) return;
    auto& [by_a, by_b] = *jacobians;
    by_a << -weight_ * point_.transpose() * tangent_basis(a.normal), -weight_;
    by_b << -weight_ * point_.transpose() * tangent_basis(b.normal), -weight_;
  }

 private:
  Eigen::Vector3d point_;
  double thickness_;
  double weight_;
};

}  // namespace

CostPtr make_cost(const WallThickness& factor) { return std::make_unique<WallThicknessCost>(factor); }

}  // namespace sgraph
