#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// What is not there any more: people who walked by, doors that were opened, things carried away. A place is empty when, after a keyframe last hit
/// it, two later ones looked through it without hitting anything in or beside it. It counts as empty, too, when it was so before and has been hit by
/// no more than two keyframes since: whoever walks by stays no longer. Where somebody has come twice or more often, four or six keyframes are needed.
/// What the last visit saw for longer stays, and so does what is thin: whoever looks at a table's leg closely enough to see through the place beside
/// it hits the leg too. Points on planes of the graph are never counted as gone, for rays that graze a floor pass just above it; but for planes of
/// which nearly all is empty, which people make who walk along a line.
class SeenThrough {
 public:
  /// Reads the keyframes' clouds once. A byte a cell of 0.2 m near the path, six while it is made; larger cells where that would be
  /// too many.
  SeenThrough(const GraphSnapshot& snapshot, const Pose& T_base_lidar);

  /// Whether a point (map frame) of some keyframe's cloud is of something that is gone.
  [[nodiscard]] bool operator()(const Eigen::Vector3d& p_map) const;

  /// Edge of the cells [m].
  [[nodiscard]] double cell() const { return cell_; }

 private:
  struct Surface {
    Plane plane;
    std::vector<Eigen::Vector3d> outline;
    Eigen::AlignedBox3d box;
  };

  // What the keyframes have shown of a cell, one after the other.
  struct Cell {
    std::uint8_t passes : 2;   // keyframes that looked through it since it was last hit,
    std::uint8_t hits : 3;     // and that hit it since it was last empty;
    std::uint8_t comings : 2;  // how often it was hit after it had been empty

    Cell() : passes(0), hits(0), comings(0) {}
    void hit();
    void look_through();
    [[nodiscard]] bool is_empty() const;
  };

  /// Which cells a plane of the graph passes.
  [[nodiscard]] std::vector<std::uint8_t> plane_cells() const;
  /// Whether most of a plane's cells are empty again: people who walk along a line are a wall to whoever puts their scans together.
  [[nodiscard]] bool is_of_passers(const Surface& surface) const;
  template <class Visit>
  void visit_cells(const Surface& surface, Visit&& visit) const;
  [[nodiscard]] bool is_on_a_plane(const Eigen::Vector3d& p_map) const;
  [[nodiscard]] std::size_t index(const Eigen::Vector3i& cell) const {
    return static_cast<std::size_t>((std::int64_t{cell.z()} * size_.y() + cell.y()) * size_.x() + cell.x());
  }
  [[nodiscard]] Eigen::Vector3i cell_of(const Eigen::Vector3d& p_map) const { return ((p_map - origin_) / cell_).array().floor().cast<int>(); }
  [[nodiscard]] bool holds(const Eigen::Vector3i& cell) const { return (cell.array() >= 0).all() && (cell.array() < size_.array()).all(); }

  double cell_ = 0;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  std::vector<Cell> cells_;
  std::vector<Surface> surfaces_;
};

}  // namespace sgraph
