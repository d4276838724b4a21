#pragma once

#include <string>

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

struct PrefilterParams {
  double min_range = 0.5;
  double max_range = 60.0;
  double range_sigmas = 0.0;
  bool keep_mixed_pixels = false;
  double leaf = 0.1;
  std::string outliers = "none";
  double outlier_radius = 0.5;
  int outlier_neighbours = 2;
  double outlier_sigmas = 2.0;

  void describe(ParamVisitor& v) {
    v.field("min_range", min_range, "m", {0, 100}, "Nearer points are dropped (the robot itself).");
    v.field("max_range", max_range, "m", {0.1, 1000}, "Farther points are dropped.");
    v.field("range_sigmas", range_sigmas, "", {0, 100},
            "Ranges outside mean +- this many standard deviations of the scan's ranges are dropped, as in the paper; 0: off.");
    v.field("keep_mixed_pixels", keep_mixed_pixels,
            "Points that float between two surfaces are kept: ranges of beams that strike an edge. They need the points' rings, each in order of "
            "azimuth.");
    v.field("leaf", leaf, "m", {0, 10}, "Edge of the voxels of which one point each is kept; 0: all points.");
    v.choice("outliers", outliers, {"none", "radius", "statistical"}, "Outlier removal after thinning.");
    v.field("outlier_radius", outlier_radius, "m", {0.01, 10}, "Radius within which `radius` looks for neighbours.");
    v.field("outlier_neighbours", outlier_neighbours, "", {1, 200}, "Neighbours that `radius` asks for, or that `statistical` averages over.");
    v.field("outlier_sigmas", outlier_sigmas, "", {0, 10},
            "`statistical` drops points whose mean distance exceeds the average by this many standard deviations.");
  }
};

}  // namespace sgraph
