#pragma once

#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// Joins the slices of a turn, which a driver publishes as clouds of their own, to whole turns. One caller.
class SliceJoiner {
 public:
  /// `turn`: how long a turn takes [s]; `turn_sign`: +1 counter-clockwise.
  SliceJoiner(double turn, double turn_sign) : turn_(turn), turn_sign_(turn_sign) {}

  /// Takes the next slice, its points with times. Appends the turn that it completes, or that it shows to be over, to `scans`. A turn bears the stamp
  /// of its newest slice.
  void add(Cloud slice, std::vector<CloudPtr>& scans);

 private:
  double turn_;
  double turn_sign_;
  Cloud joined_;             // the turn being put together; its points' times count from its stamp
  double joined_sweep_ = 0;  // [rad]
  double joined_end_ = 0;    // azimuth of its last firing [rad]
};

}  // namespace sgraph
