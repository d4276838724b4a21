#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sgraph::test {

struct SidePoint {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;  ///< of its side, into the box
};

/// Which pairs of a box's sides there are.
struct BoxSides {
  bool level = true;   ///< floor and ceiling
  bool across = true;  ///< the walls at low and high x; those at low and high y always are
};

/// Points scattered over the inner sides of a box around the origin, with Gaussian noise across the sides.
std::vector<SidePoint> noisy_box(const Eigen::Vector3d& size, BoxSides sides, int count, double noise, std::uint32_t seed);

}  // namespace sgraph::test
