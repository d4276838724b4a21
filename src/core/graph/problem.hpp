#pragma once

#include <vector>

#include "cost_blocks.hpp"
#include "factors/plane_observation.hpp"
#include "normal_equations.hpp"
#include "sgraph_slam/core/graph/recent_solver.hpp"

namespace sgraph {

/// Some variables of a graph and the terms of the cost that reach them, in arrays; the values are kept apart, so that a step can be tried.
class Problem {
 public:
  struct Variable {
    VariableId id;
    int number = -1;  ///< among the free keyframes, or among the free landmarks; -1: stays where it is
  };
  using Values = std::vector<Block>;  ///< in the order of the variables

  /// Of the factors of all free variables. The first keyframe isn't free (gauge), nor what has no factors.
  Problem(const Graph& graph, const SolveScope& scope);
  /// Of these factors only, which may reach other variables too; further views of free planes are given as sums.
  Problem(const Graph& graph, const SolveScope& scope, const std::vector<const Factor*>& factors,
          const std::vector<std::pair<PlaneId, const FixedViews*>>& fixed);

  [[nodiscard]] const std::vector<Variable>& variables() const { return variables_; }
  /// Null when no factor reaches it.
  [[nodiscard]] const Variable* find(const VariableId& id) const;
  [[nodiscard]] const Values& start() const { return start_; }
  [[nodiscard]] int factors() const { return factors_; }
  [[nodiscard]] int free_keyframes() const { return keyframes_; }
  [[nodiscard]] int free_planes() const { return planes_; }

  /// Equations to be filled; made before the first linearisation.
  [[nodiscard]] NormalEquations pattern();
  /// Fills equations of the pattern and returns the cost (half the sum of squares, robust losses applied).
  double linearize(const Values& values, NormalEquations& equations) const;
  [[nodiscard]] double cost(const Values& values) const;
  /// The values after a step in the order of the equations.
  [[nodiscard]] Values moved(const Values& values, const Eigen::VectorXd& step) const;

 private:
  struct View {
    PlaneObservation observation;
    RobustLoss loss;
    int keyframe;  // variables
    int plane;
    std::size_t block = 0;  // of the two in the equations, when both are free
  };
  struct Term {
    CostPtr cost;
    RobustLoss loss;
    std::array<int, 2> variable{-1, -1};
    int count;
    std::size_t block = 0;
  };
  struct Prior {
    FixedViews views;
    int plane;
  };

  void number_variables(const Graph& graph, const SolveScope& scope, const std::vector<VariableId>& ids);
  void add(const Graph& graph, const Factor& factor);
  [[nodiscard]] int index_of(const VariableId& id) const;
  [[nodiscard]] int number(int variable) const { return variables_[static_cast<std::size_t>(variable)].number; }
  [[nodiscard]] bool is_keyframe(int variable) const { return variable < keyframe_variables_; }
  void add_view(const View& view, const Eigen::Vector3d& e, double weight, const PlaneObservation::ByPose& by_pose, const Eigen::Matrix3d& by_plane,
                NormalEquations& equations) const;
  void add_term(const Term& term, const SmallVector& e, double weight, const std::array<SmallMatrix, 2>& jacobians, NormalEquations& equations) const;

  std::vector<Variable> variables_;  // keyframes, planes, rooms, corridors
  std::array<std::vector<std::int64_t>, 4> ids_;
  std::array<int, 4> first_{};
  int keyframe_variables_ = 0;
  int keyframes_ = 0;
  int planes_ = 0;
  int factors_ = 0;
  Values start_;
  std::vector<View> views_;
  std::vector<Term> terms_;
  std::vector<Prior> priors_;
  std::vector<int> landmark_widths_;
};

}  // namespace sgraph
