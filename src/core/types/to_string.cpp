#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/plane.hpp"

namespace sgraph {

const char* to_string(PlaneClass value) {
  switch (value) {
    case PlaneClass::x: return "x";
    case PlaneClass::y: return "y";
    case PlaneClass::horizontal: return "horizontal";
    case PlaneClass::unclassified: break;
  }
  return "unclassified";
}

const char* to_string(OdometryStatus value) {
  switch (value) {
    case OdometryStatus::started: return "started";
    case OdometryStatus::tracked: return "tracked";
    case OdometryStatus::predicted: return "predicted";
    case OdometryStatus::external: break;
  }
  return "external";
}

}  // namespace sgraph
