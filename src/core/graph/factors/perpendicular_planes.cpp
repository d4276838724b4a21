#include "sgraph_slam/core/graph/factors/perpendicular_planes.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class PerpendicularPlanesCost final : public TangentCost<PerpendicularPlanesCost, 1, PlaneBlock, PlaneBlock> {
 public:
  explicit PerpendicularPlanesCost(const PerpendicularPlanes& factor) : weight_(1.0 / factor.sigma) {}

  void evaluate(const Plane& a, const Plane& b, Residual& e, Jacobians* jacobians) const {
    e[0] = weight_ * a.normal.dot(b.normal);
    if (jacobians == nullptr) return;
    auto& [by_a, by_b] = *jacobians;
    by_a << weight_ * b.normal.transpose() * tangent_basis(a.normal), 0.0;
    by_b << weight_ * a.normal.transpose() * tangent_basis(b.normal), 0.0;
  }

 private:
  double weight_;
};

}  // namespace

CostPtr make_cost(const PerpendicularPlanes& factor) { return std::make_unique<PerpendicularPlanesCost>(factor); }

}  // namespace sgraph
