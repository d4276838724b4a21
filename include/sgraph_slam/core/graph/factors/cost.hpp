#pragma once

#include <array>
#include <memory>

namespace sgraph {

/// A variable's value as numbers: keyframe `[qx qy qz qw tx ty tz]`, plane `[nx ny nz d]`, room `[position(2) width(2)]`, corridor
/// `[position width]`. Only as many are used as the variable needs.
using Block = std::array<double, 7>;

/// What `make_cost` of a factor gives: the weighted residual with analytic Jacobians in the tangent spaces of variables.hpp.
class FactorCost {
 public:
  virtual ~FactorCost() = default;

  [[nodiscard]] virtual int residual_size() const = 0;

  /// `x`: the values of the factor's blocks in their order. `e`: the residual. `jacobians`: null, or a matrix for each block, residual_size x
  /// tangent_size, column-major.
  virtual void compute(const Block* const* x, double* e, double* const* jacobians) const = 0;
};

using CostPtr = std::unique_ptr<const FactorCost>;

}  // namespace sgraph
