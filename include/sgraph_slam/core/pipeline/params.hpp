#pragma once

#include <string>

#include "sgraph_slam/core/io/params.hpp"
#include "sgraph_slam/core/mapping/params.hpp"
#include "sgraph_slam/core/odometry/params.hpp"
#include "sgraph_slam/core/prefilter/params.hpp"
#include "sgraph_slam/core/segmentation/params.hpp"
#include "sgraph_slam/core/sensor/params.hpp"

namespace sgraph {

/// Every parameter of the package, a struct a stage.
struct Params {
  SensorParams sensor;
  PrefilterParams prefilter;
  OdometryParams odometry;
  SegmentationParams segmentation;
  MappingParams mapping;
  OutputParams output;

  void describe(ParamVisitor& v) {
    v.group("sensor", sensor, "Conventions of the LiDAR's clouds; `auto`: recognised from the first ones (docs/sensors.md).");
    v.group("prefilter", prefilter, "Thins a raw scan and drops what can't be a surface.");
    v.group("robot", odometry.robot, "What carries the LiDAR can do.");
    v.group("odometry", odometry, "Motion of the robot, local map, keyframes.");
    v.group("segmentation", segmentation, "Planes in a keyframe's cloud.");
    v.group("mapping", mapping, "The S-Graph.");
    v.group("output", output, "The files of a map.");
  }
};

/// The page docs/parameters.md: every parameter with default, unit, range and meaning.
std::string parameters_page();

}  // namespace sgraph
