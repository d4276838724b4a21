#pragma once

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

struct SegmentationParams {
  double threshold_sigmas = 2.5;
  double min_threshold = 0.02;
  double max_threshold = 0.12;
  double beam_spacing = 0.035;
  double gap = 0.3;
  double max_gap = 1.0;
  double merge_gap = 2.0;
  int min_points = 40;
  double min_length = 0.6;
  double min_width = 0.25;
  double min_area = 0.3;
  double max_rms = 0.07;
  int seeds = 400;

  void describe(ParamVisitor& v) {
    v.field("threshold_sigmas", threshold_sigmas, "", {1, 10},
            "Inliers lie within this many standard deviations of the plane; the deviation is estimated from the cloud and then for each plane.");
    v.field("min_threshold", min_threshold, "m", {0.001, 1}, "The inliers' limit is never below this, however good the sensor.");
    v.field("max_threshold", max_threshold, "m", {0.001, 1}, "... and never above this.");
    v.field("beam_spacing", beam_spacing, "rad", {0.0001, 0.5}, "Angle between neighbouring rings of the LiDAR (VLP-16: 2 deg).");
    v.field("gap", gap, "m", {0.01, 10},
            "Points of one plane belong together across this gap, or across one and a half rings where these lie farther apart.");
    v.field("max_gap", max_gap, "m", {0.01, 10}, "... but never across more than this.");
    v.field("merge_gap", merge_gap, "m", {0, 100},
            "Pieces of a wall that are coplanar within the noise are one segment across a gap of up to this (doors, windows).");
    v.field("min_points", min_points, "", {10, 100000}, "Smallest plane, in points.");
    v.field("min_length", min_length, "m", {0, 100}, "Smallest plane, along its longer side.");
    v.field("min_width", min_width, "m", {0.01, 100},
            "Smallest plane, along its shorter side; narrower ones are edges, or single stripes, that hold no normal.");
    v.field("min_area", min_area, "m^2", {0, 1000}, "Smallest plane, in the area of its outline.");
    v.field("max_rms", max_rms, "m", {0.001, 1}, "Rougher surfaces are no planes, whatever the noise.");
    v.field("seeds", seeds, "", {10, 100000}, "Places where planes are looked for, at most, in each of up to three rounds.");
  }
};

}  // namespace sgraph
