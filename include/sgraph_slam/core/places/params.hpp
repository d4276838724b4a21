#pragma once

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

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

}  // namespace sgraph
