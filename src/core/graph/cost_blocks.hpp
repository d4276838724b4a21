#pragma once

#include <array>

#include <Eigen/Core>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// Cost of any factor; the graph gives the constants of rooms and corridors, so it must have the factor's variables.
CostPtr make_cost(const FactorData& factor, const Graph& graph);

/// Value of a variable that is in the graph.
Block block_of(const Graph& graph, const VariableId& id);

/// Writes a block back into the graph, made unit length again where that applies.
void set_from_block(Graph& graph, const VariableId& id, const Block& block);

/// The value moved by a step in the variable's tangent space (variables.hpp); exact to first order: rotation and translation of a pose apart, the
/// normal of a plane along a straight line and made unit length.
Block moved(const VariableId& id, const Block& block, const double* step);

using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1>;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

/// A factor without its robust loss: weighted residual, and Jacobians by each of its blocks in our tangent spaces.
struct Linearization {
  SmallVector residual;
  std::array<SmallMatrix, 2> jacobians;
};

/// At the graph's values; the graph must have the factor's variables.
Linearization linearize(const Graph& graph, const FactorData& factor);
SmallVector residual_of(const Graph& graph, const FactorData& factor);

}  // namespace sgraph
