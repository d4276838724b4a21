#pragma once

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

/// Loop closure: by scan matching near where the graph has the robot (paper, Loop Closure), and by what walls and free space look like where the
/// graph doesn't know well enough where that is.
struct LoopParams {
  bool enabled = true;
  double max_distance = 4.0;
  double min_path = 25.0;
  double min_interval = 8.0;
  double min_sigma = 0.03;
  double voxel = 0.2;
  double resolution = 1.0;
  double max_fitness = 0.05;
  double min_overlap = 0.6;
  double chi_square = 16.8;
  double sigma_angle = 0.005;
  double sigma_distance = 0.03;
  double loss_scale = 1.0;
  bool appearance = true;
  double appearance_sigma = 0.3;
  double appearance_interval = 1.0;
  int appearance_views = 3;
  double appearance_span = 4.0;

  void describe(ParamVisitor& v) {
    v.field("enabled", enabled, "Close loops by matching scans.");
    v.field("max_distance", max_distance, "m", {0.1, 100}, "Keyframes no further apart than this are candidates.");
    v.field("min_path", min_path, "m", {1, 10000}, "Least path travelled between the two.");
    v.field("min_interval", min_interval, "m", {0, 1000}, "Least path travelled since the last loop.");
    v.field("min_sigma", min_sigma, "m", {0, 10},
            "Tried only where the graph's standard deviation of the way between the two is at least this: the walls have closed the others.");
    v.field("voxel", voxel, "m", {0.02, 2}, "Grid to which both clouds are thinned.");
    v.field("resolution", resolution, "m", {0.1, 10}, "Cell of the normal distributions transform.");
    v.field("max_fitness", max_fitness, "m^2", {0.0001, 10}, "Largest mean squared distance of matched points.");
    v.field("min_overlap", min_overlap, "", {0, 1}, "Least share of points with a match.");
    v.field("chi_square", chi_square, "", {1, 1000},
            "Largest squared Mahalanobis distance of the match from what the graph expects, 6 degrees of freedom.");
    v.field("sigma_angle", sigma_angle, "rad", {1e-4, 1}, "Standard deviation of a match's rotation.");
    v.field("sigma_distance", sigma_distance, "m", {1e-4, 1}, "Standard deviation of a match's translation.");
    v.field("loss_scale", loss_scale, "", {0.1, 100}, "Cauchy loss of a loop, in standard deviations.");
    v.field("appearance", appearance, "Close loops by what walls and free space look like from above, wherever the graph has the robot.");
    v.field("appearance_sigma", appearance_sigma, "m", {0.05, 100},
            "Searched only while the graph's standard deviation of the position since the beginning is at least this: planes and scans bridge less.");
    v.field("appearance_interval", appearance_interval, "m", {0.1, 100}, "Path travelled between two searches.");
    v.field("appearance_views", appearance_views, "", {2, 20}, "Searches that must find the same way back to the old part of the map.");
    v.field("appearance_span", appearance_span, "m", {0, 100}, "Least path travelled from the first to the last of them.");
  }
};

}  // namespace sgraph
