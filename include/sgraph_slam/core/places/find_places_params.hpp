#pragma once

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

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
