#pragma once

#include <memory>

namespace ceres {
class CostFunction;
}

namespace sgraph {

/// What `make_cost` of a factor gives: the weighted residual with analytic Jacobians, as Ceres takes it. The parameter blocks are, in Ceres' order:
/// keyframe `[qx qy qz qw tx ty tz]`, plane `[nx ny nz d]`, room `[position(2) width(2)]`, corridor `[position width]`.
using CostPtr = std::unique_ptr<ceres::CostFunction>;

}  // namespace sgraph
