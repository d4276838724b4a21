#pragma once

#include <string>

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

/// Which walls make a room (paper, Topological Layer and Experimental Validation).
struct RoomParams {
  double min_width = 2.0;
  double max_width = 12.5;
  double corridor_width = 3.5;
  double corridor_aspect = 3.0;
  double parallel = 0.1745;
  double min_side_coverage = 0.5;
  double min_wall_coverage = 0.3;
  double min_coverage = 0.7;
  double coplanar = 0.12;
  double furniture_depth = 0.8;
  double cut_share = 0.6;

  void describe(ParamVisitor& v) {
    v.field("min_width", min_width, "m", {0.5, 50}, "Smallest distance between facing walls of a room. Paper: 3.5.");
    v.field("max_width", max_width, "m", {1, 200}, "Largest distance between facing walls of a room. Paper: 6.0; real buildings have larger rooms.");
    v.field("corridor_width", corridor_width, "m", {0.5, 20},
            "A place no wider than this and long is a corridor, also when its ends are closed. Paper: 3.0.");
    v.field("corridor_aspect", corridor_aspect, "", {1, 20}, "Long means: length over width at least this.");
    v.field("parallel", parallel, "rad", {0.01, 0.5},
            "Largest angle between the walls of a facing pair, and off the right angle between pairs. Paper: 10 degrees.");
    v.field("min_side_coverage", min_side_coverage, "", {0, 1}, "Least share of each side where wall, or furniture before it, has been seen.");
    v.field("min_wall_coverage", min_wall_coverage, "", {0, 1}, "Least share of each side where the wall itself has been seen.");
    v.field("min_coverage", min_coverage, "", {0, 1}, "Least share of the whole outline where wall, or furniture before it, has been seen.");
    v.field("coplanar", coplanar, "m", {0, 1}, "Planes no further apart than this, seen from the same side, count as one wall of a place.");
    v.field("furniture_depth", furniture_depth, "m", {0, 3},
            "Surfaces up to this far before a wall, facing as it does, are furniture: they neither bound nor cut the room.");
    v.field("cut_share", cut_share, "", {0.1, 1}, "A wall over at least this share of the room's width, inside of it, cuts the room in two.");
  }
};

/// Which walls make a corridor.
struct CorridorParams {
  double min_width = 0.9;
  double max_width = 3.5;
  double min_length = 4;
  double max_length = 200;
  double min_aspect = 2;
  double closed_aspect = 3;
  double parallel = 0.1745;
  double min_coverage = 0.5;
  double max_gap = 4.5;
  double coplanar = 0.12;

  void describe(ParamVisitor& v) {
    v.field("min_width", min_width, "m", {0.3, 20}, "Smallest distance between the walls of a corridor. Paper: 1.5.");
    v.field("max_width", max_width, "m", {0.5, 20}, "Largest distance between the walls of a corridor. Paper: 3.0.");
    v.field("min_length", min_length, "m", {0.5, 200}, "Smallest common length of its walls. Paper: 4.0.");
    v.field("max_length", max_length, "m", {1, 1000}, "Largest common length of its walls. Paper: 15.0; real corridors are longer.");
    v.field("min_aspect", min_aspect, "", {1, 20}, "Least length over width.");
    v.field("closed_aspect", closed_aspect, "", {1, 20}, "Least length over width when walls close both ends; a shorter one is a small room.");
    v.field("parallel", parallel, "rad", {0.01, 0.5}, "Largest angle between the two walls.");
    v.field("min_coverage", min_coverage, "", {0, 1}, "Least share of each side where wall has been seen.");
    v.field("max_gap", max_gap, "m", {0, 20}, "Openings up to this length (doors, crossing corridors) do not end a corridor.");
    v.field("coplanar", coplanar, "m", {0, 1}, "Planes no further apart than this, seen from the same side, count as one wall of a place.");
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
  }
};

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

/// Planes that turn out to be one (paper: soft loop closure).
struct MergeParams {
  bool enabled = true;
  bool by_places = true;
  double chi_square = 7.81;
  double max_angle = 0.0873;
  double max_distance = 0.4;
  double sigma_angle = 0.006;
  double sigma_distance = 0.01;
  double max_growth = 2.0;
  double max_error = 3.0;

  void describe(ParamVisitor& v) {
    v.field("enabled", enabled, "Merge planes that turn out to be one surface.");
    v.field("by_places", by_places,
            "A room or corridor seen again shows which planes are one wall: these merge more readily (paper: soft loop closure).");
    v.field("chi_square", chi_square, "", {1, 100}, "Largest squared Mahalanobis distance between the two, 3 degrees of freedom.");
    v.field("max_angle", max_angle, "rad", {0.001, 0.5}, "Largest angle between their normals.");
    v.field("max_distance", max_distance, "m", {0.01, 10}, "Largest distance between them, however uncertain they are.");
    v.field("sigma_angle", sigma_angle, "rad", {0, 0.2}, "Standard deviation added to the angle in the gate.");
    v.field("sigma_distance", sigma_distance, "m", {0, 0.5}, "Standard deviation added to the distance in the gate.");
    v.field("max_growth", max_growth, "", {1, 100},
            "A merge is undone when the mean chi-square of the observations grows by more than this factor ...");
    v.field("max_error", max_error, "", {0.1, 100}, "... to more than this per degree of freedom.");
  }
};

/// Factors of the topological layer.
struct TopologyParams {
  bool rooms = true;
  bool corridors = true;
  bool parallel_factors = true;
  bool perpendicular_factors = true;
  bool width_factors = false;
  bool thickness_factors = false;
  double wall_sigma = 0.02;
  double angle_sigma = 0.0175;
  double width_sigma = 0.03;
  double thickness_sigma = 0.02;
  double loss_scale = 2.0;
  double judge_slack = 0.25;
  int withdraw_after = 3;
  int recent = 20;
  int min_views = 3;
  double min_height = 1.2;

  void describe(ParamVisitor& v) {
    v.field("rooms", rooms, "Find rooms.");
    v.field("corridors", corridors, "Find corridors.");
    v.field("parallel_factors", parallel_factors, "Facing walls of rooms and corridors are parallel: as factors on the normals.");
    v.field("perpendicular_factors", perpendicular_factors, "Neighbouring walls of a room are perpendicular: as factors on the normals.");
    v.field("width_factors", width_factors, "Widths as single keyframes see them: as factors on rooms and corridors.");
    v.field("thickness_factors", thickness_factors,
            "The two faces of a wall are as far apart as those of the other walls of the building: as factors.");
    v.field("wall_sigma", wall_sigma, "m", {1e-4, 1}, "Standard deviation between a room or corridor and its walls.");
    v.field("angle_sigma", angle_sigma, "rad", {1e-4, 1}, "Standard deviation of parallel and perpendicular walls.");
    v.field("width_sigma", width_sigma, "m", {1e-4, 1}, "Standard deviation added to a width seen by one keyframe.");
    v.field("thickness_sigma", thickness_sigma, "m", {1e-4, 1}, "Standard deviation of a wall's thickness.");
    v.field("loss_scale", loss_scale, "", {0.1, 100}, "Cauchy loss of all of these, in standard deviations: an oblique wall can refuse.");
    v.field("judge_slack", judge_slack, "", {0, 0.9}, "A room or corridor stands while it meets the limits eased by this share.");
    v.field("withdraw_after", withdraw_after, "", {1, 1000}, "Judgements failed in a row until a room or corridor is withdrawn.");
    v.field("min_views", min_views, "", {1, 1000}, "A wall counts for rooms and corridors once this many keyframes have seen it ...");
    v.field("min_height", min_height, "m", {0, 10}, "... over this height: desks and sofas are lower.");
    v.field("recent", recent, "", {1, 100000},
            "Walls seen in this many last keyframes are tried first: a place entered again with drift shows in them.");
  }
};

/// Hard loop closure by scan matching (paper, Loop Closure).
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
  }
};

/// Motions between keyframes measured by their scans where the odometry is poor.
struct SubmapParams {
  bool enabled = true;
  double min_sigma = 0.01;
  double leaf = 0.2;
  double min_inliers = 0.3;

  void describe(ParamVisitor& v) {
    v.field("enabled", enabled, "Measure the motion between keyframes by their scans where the odometry is poor.");
    v.field("min_sigma", min_sigma, "rad", {0, 1},
            "Poor means: the standard deviation of the rotation between keyframes, tilt included, is at least this; of wheels it is always.");
    v.field("leaf", leaf, "m", {0.05, 2}, "One point in a voxel of this edge is registered.");
    v.field("min_inliers", min_inliers, "", {0, 1}, "Below this share of matched points the odometry is believed.");
  }
};

/// When the graph is solved, and how.
struct SolveParams {
  int window = 8;
  int window_iterations = 4;
  int every = 10;
  double growth = 0.05;
  int iterations = 20;
  int final_iterations = 100;

  void describe(ParamVisitor& v) {
    v.field("window", window, "", {0, 1000}, "Newest keyframes solved at each keyframe, with the planes they see; 0: none.");
    v.field("window_iterations", window_iterations, "", {1, 100}, "At most this many iterations.");
    v.field("every", every, "", {1, 10000}, "The whole graph is solved at least after this many keyframes ...");
    v.field("growth", growth, "", {0, 1},
            "... or this share of all keyframes, whichever is more; and at once after a merge, a loop or a return to a place.");
    v.field("iterations", iterations, "", {1, 1000}, "At most this many iterations of it.");
    v.field("final_iterations", final_iterations, "", {1, 10000}, "At most this many when the whole graph is optimised on demand.");
  }
};

struct MappingParams {
  bool topological_layer = true;
  FactorParams factors;
  AssociationParams association;
  SemanticsParams semantics;
  MergeParams merging;
  TopologyParams topology;
  RoomParams rooms;
  CorridorParams corridors;
  SubmapParams submap;
  LoopParams loops;
  SolveParams solving;

  void describe(ParamVisitor& v) {
    v.field("topological_layer", topological_layer, "Rooms and corridors; off: the paper's \"w/o top. layer\".");
    v.group("factors", factors, "Weights and losses of the odometry's and the planes' factors.");
    v.group("association", association, "When a segment is a new view of a plane of the map.");
    v.group("semantics", semantics, "Axes of the building and classes of planes.");
    v.group("merging", merging, "Planes that turn out to be one.");
    v.group("topology", topology, "Factors of rooms and corridors.");
    v.group("rooms", rooms, "Which walls make a room.");
    v.group("corridors", corridors, "Which walls make a corridor.");
    v.group("submap", submap, "Motions between keyframes where the odometry is poor.");
    v.group("loops", loops, "Loop closure by scan matching.");
    v.group("solving", solving, "When the graph is solved, and how.");
  }
};

}  // namespace sgraph
