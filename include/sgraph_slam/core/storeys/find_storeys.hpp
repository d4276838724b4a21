#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace sgraph {

/// A ride in a lift on a path.
struct LiftRide {
  std::size_t position = 0;   ///< the first after it
  std::optional<int> storey;  ///< where it ended, when that has been recognised; none: on a floor that had not been seen before
};

/// The storeys that a path visits.
struct StoreysOfPath {
  std::vector<double> heights;  ///< of the path on each storey, where it was entered first [m]; at least one once there is a path
  std::vector<int> group;       ///< of each storey; the heights of those in one group are known against each other. The first's is 0
  std::vector<int> storey;      ///< of each position: an index into `heights`, or `stairwell`
};

/// Finds the storeys of a path from its shape alone. `positions`: of the robot's base at its keyframes, in order, z up [m].
///
/// The path is cut into level runs (slope up to about 5 %) and climbs between them. A level run of another height is another storey when one could
/// stand upright on the floor below it (2.2 m); what is nearer is a part of the storey it is near to (a mezzanine, a sunken lecture room, half a
/// level of a car park) when it is wider than a landing, else a landing. What lies between two storeys belongs to the stairwell, but for the first
/// and last decimetre. Who rises by more than the way he covers was lifted, and is on the storey where he was.
///
/// A ride in a lift ends on another storey, whatever the path's height says; it is not known how far above or below, so heights are compared only
/// among storeys that the robot came to by stairs from each other, or that have been recognised. `rides` in order.
///
/// The newest level run counts before it is known to be wider than a landing: a later call may take that back.
StoreysOfPath find_storeys(const std::vector<Eigen::Vector3d>& positions, const std::vector<LiftRide>& rides = {});

}  // namespace sgraph
