#pragma once

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

struct OutputParams {
  double cloud_leaf = 0.05;
  double grid_resolution = 0.05;
  double grid_low = 0.2;
  double grid_high = 1.8;
  bool keep_gone = false;
  bool keep_images = false;

  void describe(ParamVisitor& v) {
    v.field("cloud_leaf", cloud_leaf, "m", {0, 10}, "Edge of the voxels of which the map cloud holds the mean point each; 0: all points.");
    v.field("grid_resolution", grid_resolution, "m", {0.01, 1}, "Edge of a cell of the occupancy grid.");
    v.field("grid_low", grid_low, "m", {0, 10}, "What is lower above the floor is no obstacle in the occupancy grid.");
    v.field("grid_high", grid_high, "m", {0.1, 100}, "What is higher above the floor is no obstacle in the occupancy grid.");
    v.field("keep_gone", keep_gone,
            "Cloud and grid keep what later keyframes looked through: people, doors that were opened, what was carried away.");
    v.field("keep_images", keep_images, "Cloud, grid and floor plan keep the rooms that windows mirror.");
  }
};

}  // namespace sgraph
