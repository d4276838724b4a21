#include "sgraph_slam/core/graph/factors/parallel_planes.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class ParallelPlanesCost final : public TangentCost<ParallelPlanesCost, 3, PlaneBlock, PlaneBlock> {
 public:
  explicit ParallelPlanesCost(const ParallelPlanes& factor) : weight_(1.0 / factor.sigma) {}

  void evaluate(const Plane& a, const Plane& b, Residual& e, Jacobians* jacobians) const {
    e = weight_ * a.normal.cross(b.normal);
    if (jacobians == nullptr) return;
    auto& [by_a, by_b] = *jacobians;
    by_a << -weight_ * skew(b.normal) * tangent_basis(a.normal), Eigen::Vector3d::Zero();
    by_b << weight_ * skew(a.normal) * tangent_basis(b.normal), Eigen::Vector3d::Zero();
  }

 private:
  double weight_;
};

}  // namespace

CostPtr make_cost(const ParallelPlanes& factor) { return std::make_unique<ParallelPlanesCost>(factor); }

}  // namespace sgraph
