#pragma once

#include <string>

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

/// Building frame and classes of planes.
struct SemanticsParams {
  bool dominant_frame = true;
  double tilt = 0.2618;
  double oblique = 0.2618;
  double hysteresis = 0.0349;
  double wall_gap = 0.3;

  void describe(ParamVisitor& v) {
    v.field("dominant_frame", dominant_frame, "x and y planes are told apart in the building's own axes; off: in the map's, as in the paper.");
    v.field("tilt", tilt, "rad", {0.01, 0.7}, "Largest tilt of a wall from the vertical, of a floor from the horizontal.");
    v.field("oblique", oblique, "rad", {0.01, 0.78}, "Walls further than this off both axes of the building are unclassified.");
    v.field("hysteresis", hysteresis, "rad", {0, 0.3}, "A class is left when its limit is passed by this much.");
    v.field("wall_gap", wall_gap, "m", {0, 5}, "Gaps in a wall shorter than this count as seen.");
  }
};

/// When a segment is a new view of a plane of the map (paper, Metric-Semantic Layer; design: Planes).
struct AssociationParams {
  double chi_square = 7.81;
  double max_angle = 0.2618;
  double max_distance = 0.6;
  double extent_margin = 1.2;
  double sigma_angle = 0.006;
  double sigma_distance = 0.015;
  double min_new_area = 0.25;
  int drop_after = 30;
  int drop_views = 2;
  double drop_area = 1.5;
  int drop_ghost_after = 10;
  double ghost_distance = 0.12;

  void describe(ParamVisitor& v) {
    v.field("chi_square", chi_square, "", {1, 100}, "Largest squared Mahalanobis distance, 3 degrees of freedom; 7.81 keeps 95 % of the right ones.");
    v.field("max_angle", max_angle, "rad", {0.01, 0.8}, "Largest angle between the normals, signed: the two faces of a wall never match.");
    v.field("max_distance", max_distance, "m", {0.05, 10}, "Largest distance of the segment's centroid from the plane, however uncertain both are.");
    v.field("extent_margin", extent_margin, "m", {0, 10},
            "Largest gap on the plane between the segment and what has been seen of it; a door is bridged, a crossing corridor is not.");
    v.field("sigma_angle", sigma_angle, "rad", {0, 0.2}, "Standard deviation added to a segment's normal in the gate: what all its points share.");
    v.field("sigma_distance", sigma_distance, "m", {0, 0.5}, "Standard deviation added to a segment's distance in the gate.");
    v.field("min_new_area", min_new_area, "m^2", {0, 100}, "A segment that matches nothing makes a plane when it is at least this large.");
    v.field("drop_after", drop_after, "", {1, 1000000}, "A plane that hasn't been seen in this many keyframes is dropped again ...");
    v.field("drop_views", drop_views, "", {0, 1000}, "... when no more than this many saw it: it says next to nothing about them ...");
    v.field("drop_area", drop_area, "m^2", {0, 1000}, "... and its extent is smaller than this: people, clutter, pieces of glass.");
    v.field("drop_ghost_after", drop_ghost_after, "", {1, 1000000},
            "A plane of any size with no more than drop_views is dropped when this many keyframes haven't seen it and a plane known much better ...");
    v.field("ghost_distance", ghost_distance, "m", {0, 1}, "... faces the same way no further off than this. 0: never.");
  }
};

/// Weights and losses of the factors of the two lower layers.
struct FactorParams {
  std::string plane_factor = "tangent";
  double keyframe_floor_angle = 0.0005;
  double keyframe_floor_distance = 0.003;
  double degenerate_angle = 0.05;
  double degenerate_distance = 0.3;
  double plane_floor_angle = 0.003;
  double plane_floor_distance = 0.006;
  double point_sigma = 0.02;
  std::string plane_loss = "huber";
  double plane_loss_scale = 2.5;
  int spot_keyframes = 8;
  bool storey_factors = true;

  void describe(ParamVisitor& v) {
    v.choice("plane_factor", plane_factor, {"tangent", "points"},
             "An observed plane enters as the fitted plane, or as its points (plane adjustment).");
    v.field("keyframe_floor_angle", keyframe_floor_angle, "rad", {1e-6, 1}, "Least standard deviation of the rotation between keyframes.");
    v.field("keyframe_floor_distance", keyframe_floor_distance, "m", {1e-6, 1}, "Least standard deviation of the translation between keyframes.");
    v.field("degenerate_angle", degenerate_angle, "rad", {0, 10},
            "Standard deviation added to the rotation between keyframes along a direction that the odometry's data didn't hold.");
    v.field("degenerate_distance", degenerate_distance, "m", {0, 100}, "Likewise to the translation.");
    v.field("plane_floor_angle", plane_floor_angle, "rad", {1e-6, 1}, "Least standard deviation of an observed normal.");
    v.field("plane_floor_distance", plane_floor_distance, "m", {1e-6, 1}, "Least standard deviation of an observed distance.");
    v.field("point_sigma", point_sigma, "m", {1e-4, 1}, "Standard deviation of a point's distance from its plane, for the points form.");
    v.choice("plane_loss", plane_loss, {"none", "huber", "cauchy", "tukey", "geman_mcclure"}, "Robust loss of plane observations.");
    v.field("plane_loss_scale", plane_loss_scale, "", {0.1, 100}, "In standard deviations.");
    v.field("spot_keyframes", spot_keyframes, "", {0, 1000},
            "A keyframe is retired when this many older ones stand within half a metre and show most of the planes that it shows. 0: none is.");
    v.field("storey_factors", storey_factors, "Storeys of one building have level floors, and walls stand on walls.");
  }
};

/// Planes that turn out to be one (paper: soft loop closure).
struct MergeParams {
  bool enabled = true;
  bool by_places = true;
  double chi_square = 7.81;
  double max_angle = 0.0873;
  double max_distance = 0.4;
  double sigma_angle = 0;
  double sigma_distance = 0;
  double max_growth = 2.0;
  double max_error = 3.0;

  void describe(ParamVisitor& v) {
    v.field("enabled", enabled, "Merge planes that turn out to be one surface.");
    v.field("by_places", by_places,
            "A room or corridor seen again shows which planes are one wall: these merge more readily (paper: soft loop closure).");
    v.field("chi_square", chi_square, "", {1, 100}, "Largest squared Mahalanobis distance between the two, 3 degrees of freedom.");
    v.field("max_angle", max_angle, "rad", {0.001, 0.5}, "Largest angle between their normals.");
    v.field("max_distance", max_distance, "m", {0.01, 10}, "Largest distance between them, however uncertain they are.");
    v.field("sigma_angle", sigma_angle, "rad", {0, 0.2},
            "Standard deviation added to the angle in the gate. What the gate forgives, the merged plane presses out of the poses.");
    v.field("sigma_distance", sigma_distance, "m", {0, 0.5}, "Standard deviation added to the distance in the gate.");
    v.field("max_growth", max_growth, "", {1, 100},
            "A merge is undone when the mean chi-square of the observations grows by more than this factor ...");
    v.field("max_error", max_error, "", {0.1, 100}, "... to more than this per degree of freedom.");
  }
};

}  // namespace sgraph
