#pragma once

#include <deque>
#include <optional>

#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/sensor.hpp"

namespace sgraph {

/// Measures a ride in a lift by an accelerometer that rides along.
///
/// The cabin moves straight up or down, so the norm of the specific force is gravity and the cabin's acceleration, however the unit is mounted. At
/// both ends the cabin stands still: the mean of the norm over the ride is what the unit reads for gravity (its bias and its unit included), and what
/// is above it, integrated twice, is the height (a zero-velocity update). Of white noise of density q [m^2/s^3] a ride of T seconds keeps a variance
/// of q T^3 / 12, of a bias that changes evenly by b b T^2 / 12.
class RideHeight {
 public:
  /// Readings that aren't finite or not later than the last are left out.
  void add(const ImuSample& sample);
  /// Readings before are of no ride.
  void forget_before(Stamp stamp);

  /// From the readings that are held, at whose ends the cabin must have stood still. None where they have holes, say no acceleration, or are too
  /// many.
  [[nodiscard]] std::optional<Rise> risen() const;

 private:
  struct Reading {
    Stamp stamp;
    double norm;  // of the specific force, in the unit's unit
  };
  std::deque<Reading> readings_;
};

}  // namespace sgraph
