#pragma once

#include <cstddef>
#include <numeric>

namespace sgraph {

/// Calls `visit(i)` for every i below `count`, in an order that has nothing to do with that of the indices; the same one each time.
///
/// For keeping the first point of each voxel: in the order of firing, noise brings the beam's points into the next voxel early where they are long or
/// early where they are short, by the side that the beam sweeps along, so the points kept lie turned against the sweep by about 0.007 degrees.
template <typename Visit>
void visit_scattered(std::size_t count, Visit&& visit) {
  if (count == 0) return;
  std::size_t step = count * 382 / 1000 + 1;  // the golden section: neighbours in the order are far apart
  while (std::gcd(step, count) != 1) ++step;
  for (std::size_t k = 0, i = 0; k < count; ++k) {
    visit(i);
    i += step;
    if (i >= count) i -= count;
  }
}

}  // namespace sgraph
