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
  double view_angle_sigma = 0.006;
  double angle_gate = 3.0;
  int recent = 20;
  int min_views = 3;
  double min_height = 1.2;

  void describe(ParamVisitor& v) {
    v.field("rooms", rooms, "Find rooms and halls.");
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
    v.field("view_angle_sigma", view_angle_sigma, "rad", {1e-5, 0.2},
            "Standard deviation of a wall's direction in one view: of n views, by its root of n less.");
    v.field("angle_gate", angle_gate, "", {0.1, 100},
            "Walls are taken for parallel or perpendicular while they are so within this many standard deviations of their directions.");
    v.field("min_views", min_views, "", {1, 1000}, "A wall counts for rooms and corridors once this many keyframes have seen it ...");
    v.field("min_height", min_height, "m", {0, 10}, "... over this height: desks and sofas are lower.");
    v.field("recent", recent, "", {1, 100000},
            "Of walls seen in this many last keyframes those along the sides of the present place may be its walls: a place entered again with drift "
            "shows in them.");
  }
};

/// The raster of free floor on which places are found.
struct FreeSpaceParams {
  double resolution = 0.05;
  int rays = 3000;
  double reach = 15;
  double ankle = 0.1;
  double sill = 0.75;
  double shelf = 1.4;
  double head = 1.95;

  void describe(ParamVisitor& v) {
    v.field("resolution", resolution, "m", {0.02, 0.5}, "Edge of a cell.");
    v.field("rays", rays, "", {10, 100000}, "Most rays kept of a keyframe's cloud.");
    v.field("reach", reach, "m", {1, 100}, "Rays count this far from the LiDAR.");
    v.field("ankle", ankle, "m", {0, 1}, "Rays lower above the floor count nowhere.");
    v.field("sill", sill, "m", {0.1, 2}, "What lets rays through below this is no window.");
    v.field("shelf", shelf, "m", {0.2, 3}, "Above tables and desks.");
    v.field("head", head, "m", {0.5, 10}, "Rays higher above the floor count nowhere: they pass over cupboards and under lintels.");
  }
};

/// Places of any outline: connected free floor, bounded by walls and cut at doors.
struct PlaceParams {
  double min_door = 0.55;
  double max_door = 1.65;
  double widest_door = 2.5;
  double join_share = 0.5;
  double coplanar = 0.1;
  double furniture_depth = 0.95;
  double furniture_length = 2.6;
  double robot_radius = 0.2;
  double min_area = 1.5;
  double corridor_width = 3.5;
  double corridor_aspect = 3.0;
  double min_corridor = 4.0;
  double min_corridor_width = 0.9;
  double max_corridor_gap = 4.5;

  void describe(ParamVisitor& v) {
    v.field("min_door", min_door, "m", {0.2, 5}, "Narrower gaps of a wall are none.");
    v.field("max_door", max_door, "m", {0.2, 20}, "Gaps up to this part two places, whatever their width.");
    v.field("widest_door", widest_door, "m", {0.2, 20}, "A wider opening between two places is no door.");
    v.field("join_share", join_share, "", {0.05, 1}, "A wider opening joins two places when it is more than this share of the narrower one's width.");
    v.field("coplanar", coplanar, "m", {0, 1}, "Faces no further apart than this, looking the same way, are one wall of a place.");
    v.field("furniture_depth", furniture_depth, "m", {0, 3},
            "A face up to this far before a longer one, facing as it does, is a piece of furniture ...");
    v.field("furniture_length", furniture_length, "m", {0, 20}, "... unless it is longer than this.");
    v.field("robot_radius", robot_radius, "m", {0.05, 2}, "What a disc of this radius cannot pass joins nothing.");
    v.field("min_area", min_area, "m^2", {0.1, 100}, "A smaller piece of floor is no place.");
    v.field("corridor_width", corridor_width, "m", {0.5, 20}, "A place no wider than this and long is a corridor. Paper: 3.0.");
    v.field("corridor_aspect", corridor_aspect, "", {1, 20}, "Long means: length over width at least this.");
    v.field("min_corridor", min_corridor, "m", {0.5, 200},
            "Smallest common length of a corridor's walls where it is part of a larger place. Paper: 4.0.");
    v.field("min_corridor_width", min_corridor_width, "m", {0.3, 20}, "Smallest distance between the walls of a corridor. Paper: 1.5.");
    v.field("max_corridor_gap", max_corridor_gap, "m", {0, 20}, "Openings up to this length (crossing corridors) do not end a corridor.");
  }
};

}  // namespace sgraph
