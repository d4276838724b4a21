#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// What the metric-semantic and the topological layer of a saved graph hold.
struct Structure {
  std::vector<ScenePlane> planes;
  std::vector<SceneRoom> rooms;
  std::vector<SceneCorridor> corridors;
};

/// Reads planes, rooms and corridors of a run folder's graph.json. Throws std::runtime_error with the file and what is wrong.
Structure read_structure(const std::string& path);

/// Positions of a point cloud file (PCD, any encoding) without the invalid ones. Throws std::runtime_error when it can't be read.
std::vector<Eigen::Vector3f> read_pcd_positions(const std::string& path);

}  // namespace sgraph
