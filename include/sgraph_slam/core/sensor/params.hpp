#pragma once

#include <string>

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

struct SensorParams {
  std::string times = "auto";
  std::string time_unit = "auto";
  std::string stamp = "auto";
  std::string rings = "auto";
  std::string sweep = "auto";
  std::string slices = "auto";
  double rate = 0.0;

  void describe(ParamVisitor& v) {
    v.choice("times", times, {"auto", "field", "azimuth", "none"},
             "Where the time of each point comes from: its field, the azimuth (the order of firing of a spinning LiDAR), or nowhere: all at once. "
             "auto: the field where there is one, else the azimuth.");
    v.choice("time_unit", time_unit, {"auto", "s", "ms", "us", "ns"},
             "Unit of the time field. auto: the one that makes a turn last a fraction of a second.");
    v.choice("stamp", stamp, {"auto", "first", "last"},
             "Which firing a cloud's stamp belongs to, where its points don't tell. auto: the last, unless clouds are received later than a turn "
             "after their stamps.");
    v.choice("rings", rings, {"auto", "field", "elevation", "none"},
             "Where the number of each point's beam comes from. auto: the field where there is one.");
    v.choice("sweep", sweep, {"auto", "clockwise", "counterclockwise"}, "Direction in which the sensor turns, seen from above.");
    v.choice("slices", slices, {"auto", "join", "keep"}, "Whether clouds that hold a part of a turn each are joined to whole turns.");
    v.field("rate", rate, "Hz", {0, 100}, "Turns a second, where the points don't tell; 0: from the stamps.");
  }
};

}  // namespace sgraph
