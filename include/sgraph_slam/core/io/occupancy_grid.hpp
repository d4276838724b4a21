#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/io/params.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// A floor plan for navigation, laid out as nav_msgs/OccupancyGrid: row 0 is at the lowest y.
struct OccupancyGrid {
  static constexpr std::int8_t unknown = -1;
  static constexpr std::int8_t free = 0;
  static constexpr std::int8_t occupied = 100;

  double resolution = 0.05;                          ///< edge of a cell [m]
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< lower left corner of the first cell, map frame [m]
  int width = 0;                                     ///< cells along x
  int height = 0;                                    ///< cells along y
  std::vector<std::int8_t> cells;                    ///< row by row

  /// The cell that holds a point; unknown outside.
  [[nodiscard]] std::int8_t at(const Eigen::Vector2d& p) const;
};

/// Points in a band above the floor are obstacles; what the rays from the LiDAR to the points passed within that band is free. The band is widened
/// to hold the LiDAR itself. A cell that one keyframe hits and others see through is decided by their odds; what is
/// `left_out` is no obstacle.
OccupancyGrid make_occupancy_grid(const GraphSnapshot& snapshot, const Pose& T_base_lidar, const OutputParams& params, const LeaveOut& left_out = {});

/// The same grid kept up while the map grows: only keyframes that are new, or have moved by a cell, are read. Rays of tens of kilometres are left out
/// instead of making the cells larger.
class LiveOccupancyGrid {
 public:
  explicit LiveOccupancyGrid(const OutputParams& params);
  ~LiveOccupancyGrid();

  /// Brings it up to a state of the map. A state that lacks a keyframe begins another map.
  void update(const GraphSnapshot& snapshot, const Pose& T_base_lidar);

  [[nodiscard]] OccupancyGrid grid() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// The two files of map_server: the picture (binary PGM, rows from the highest y) and what its pixels mean.
std::string pgm_bytes(const OccupancyGrid& grid);
std::string map_yaml(const OccupancyGrid& grid, const std::string& image);

}  // namespace sgraph
