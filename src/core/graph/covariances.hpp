#pragma once

#include <memory>

#include <Eigen/Core>

#include "normal_equations.hpp"

namespace sgraph {

/// Blocks of the inverse of H, for variables counted as the equations do: keyframes first, then the landmarks.
class Covariances {
 public:
  virtual ~Covariances() = default;

  /// Whether H could be inverted.
  [[nodiscard]] virtual bool ok() const = 0;
  /// Block of two variables; they may be one.
  virtual Eigen::MatrixXd block(int a, int b) = 0;
};

/// By a sparse factorisation of the whole: exact. Cheap for variables that factors join (selected inverse); for others it takes a solve a degree of
/// freedom of `b`, kept for later questions.
std::unique_ptr<Covariances> make_exact_covariances(const NormalEquations& equations);

/// By a trajectory that bends at its nodes only (coarse_motion.hpp), at most `most_nodes` and each of the newest keyframes: landmarks eliminated, the
/// rest dense. Exact when every keyframe is a node; otherwise what keyframes between two nodes would move against both is left out, and covariances
/// come out a little too small.
std::unique_ptr<Covariances> make_coarse_covariances(const NormalEquations& equations, int most_nodes);

}  // namespace sgraph
