#pragma once

#include <string>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// What to make of the information matrices in a file: `full` takes them as they are; `isotropic` one weight for the rotation and one for the
/// translation, from the mean variances, as SE-Sync and the papers that compare with it do.
enum class G2oWeights { full, isotropic };

/// Reads a pose graph in g2o's text format: VERTEX_SE3:QUAT (keyframes), EDGE_SE3:QUAT with the full information matrix (Se3Between; the rotation's
/// information is taken as that of the angle, as GTSAM, SE-Sync and Ceres' example take it; g2o's own error is half the angle). FIX and comments are
/// passed over. Vertices missing in the file but named by an edge start at the identity: see initialise_chordal. Throws std::runtime_error with file,
/// line and reason.
Graph read_g2o(const std::string& path, G2oWeights weights = G2oWeights::full);

/// Writes the keyframes and the Se3Between factors.
void write_g2o(const std::string& path, const Graph& graph);

/// Poses from the Se3Between factors alone, without a guess: rotations from the linear relaxation (chordal), then translations, both sparse linear
/// least squares. (Carlone et al., Initialization techniques for 3D SLAM, ICRA 2015). Keyframes that no path of factors ties to the first keep their
/// poses.
void initialise_chordal(Graph& graph);

}  // namespace sgraph
