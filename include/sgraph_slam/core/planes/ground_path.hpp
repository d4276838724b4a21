#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// The robot's path on the ground (map frame, straight between its points), with a grid by which the steps near a place are found without asking all.
class GroundPath {
 public:
  explicit GroundPath(std::vector<Eigen::Vector2d> points);
  /// Several stretches; nobody walked from one to the next.
  explicit GroundPath(const std::vector<std::vector<Eigen::Vector2d>>& stretches);
  /// The positions of the keyframes, in order.
  explicit GroundPath(const Graph& graph);

  [[nodiscard]] const std::vector<Eigen::Vector2d>& points() const { return points_; }

  /// Steps (by the index of their end) that may come near the straight line between two points, in order; all that cross it are among them.
  [[nodiscard]] std::vector<std::size_t> steps_near(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;

  void add(const std::vector<Eigen::Vector2d>& stretch);

  std::vector<Eigen::Vector2d> points_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

}  // namespace sgraph
