#pragma once

#include <array>
#include <memory>
#include <vector>

#include <ceres/loss_function.h>
#include <Eigen/Core>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// Cost of any factor; the graph gives the constants of rooms and corridors, so it must have the factor's variables.
CostPtr make_cost(const FactorData& factor, const Graph& graph);

/// `s / (1 + s / scale^2)`: lets go of an outlier altogether. Ceres has none.
class GemanMcClureLoss final : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double scale) : squared_scale_(scale * scale) {}
  void Evaluate(double s, double rho[3]) const override;

 private:
  double squared_scale_;
};

/// Null for LossKind::none.
std::unique_ptr<ceres::LossFunction> make_loss(const RobustLoss& loss);

/// A variable as a Ceres parameter block; only the first `block_size` numbers are used.
using Block = std::array<double, 7>;
int block_size(const VariableId& id);

/// Block of a variable that is in the graph.
Block block_of(const Graph& graph, const VariableId& id);

/// Writes a block back into the graph, made unit length again where that applies.
void set_from_block(Graph& graph, const VariableId& id, const Block& block);

using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1>;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

/// A factor at the graph's values, without its robust loss: weighted residual, and Jacobians by each of its blocks in our tangent spaces.
struct Linearization {
  SmallVector residual;
  std::array<SmallMatrix, 2> jacobians;
};

/// The graph must have the factor's variables.
Linearization linearize(const Graph& graph, const FactorData& factor);
SmallVector residual_of(const Graph& graph, const FactorData& factor);

}  // namespace sgraph
