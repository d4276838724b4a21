#include "sgraph_slam/core/graph/factors/aligned_walls.hpp"

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class AlignedWallsCost final : public TangentCost<AlignedWallsCost, 2, PlaneBlock, PlaneBlock> {
 public:
  explicit AlignedWallsCost(const AlignedWalls& factor)
      : below_{factor.from, factor.to}, rise_(factor.rise * Eigen::Vector3d::UnitZ()), weight_(1.0 / factor.sigma) {}

  void evaluate(const Plane& a, const Plane& b, Residual& e, Jacobians* jacobians) const {
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector3d& below = below_[static_cast<std::size_t>(i)];
      const Eigen::Vector3d above = below + rise_;
      e[i] = weight_ * (a.distance(below) - b.distance(above));
      if (jacobians == nullptr) continue;
      auto& [by_a, by_b] = *jacobians;
      by_a.row(i) << weight_ * below.transpose() * tangent_basis(a.normal), weight_;
      by_b.row(i) << -weight_ * above.transpose() * tangent_basis(b.normal), -weight_;
    }
  }

 private:
  std::array<Eigen::Vector3d, 2> below_;
  Eigen::Vector3d rise_;
  double weight_;
};

}  // namespace

CostPtr make_cost(const AlignedWalls& factor) { return std::make_unique<AlignedWallsCost>(factor); }

}  // namespace sgraph
