#include "sgraph_slam/core/graph/factors/aligned_walls.hpp"

#include <cmath>

#include "tangent_cost.hpp"

namespace sgraph {
namespace {

class AlignedWallsCost final : public TangentCost<AlignedWallsCost, 2, PlaneBlock, PlaneBlock> {
 public:
  explicit AlignedWallsCost(const AlignedWalls& factor)
      : from_(factor.from),
        to_(factor.to),
        rise_(factor.rise * Eigen::Vector3d::UnitZ()),
        weights_(M_SQRT1_2 / factor.shift_sigma, M_SQRT1_2 / factor.sigma) {}

  void evaluate(const Plane& a, const Plane& b, Residual& e, Jacobians* jacobians) const {
    const double at_from = a.distance(from_) - b.distance(from_ + rise_);
    const double at_to = a.distance(to_) - b.distance(to_ + rise_);
    e << weights_[0] * (at_from + at_to), weights_[1] * (at_from - at_to);
    if (jacobians == nullptr) return;
    auto& [by_a, by_b] = *jacobians;
    by_a << weights_[0] * (from_ + to_).transpose() * tangent_basis(a.normal), 2 * weights_[0],
        weights_[1] * (from_ - to_).transpose() * tangent_basis(a.normal), 0;
    by_b << -weights_[0] * (from_ + to_ + 2 * rise_).transpose() * tangent_basis(b.normal), -2 * weights_[0],
        -weights_[1] * (from_ - to_).transpose() * tangent_basis(b.normal), 0;
  }

 private:
  Eigen::Vector3d from_;
  Eigen::Vector3d to_;
  Eigen::Vector3d rise_;
  Eigen::Vector2d weights_;
};

}  // namespace

CostPtr make_cost(const AlignedWalls& factor) { return std::make_unique<AlignedWallsCost>(factor); }

}  // namespace sgraph
