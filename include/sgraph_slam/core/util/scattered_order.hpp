#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

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

/// The items that `keep` accepts: asked once each in scattered order, returned in their own.
template <typename Item, typename Keep>
std::vector<Item> kept_scattered(const std::vector<Item>& items, Keep&& keep) {
  std::vector<char> kept(items.size());
  visit_scattered(items.size(), [&](std::size_t i) { kept[i] = keep(items[i]); });
  std::vector<Item> result;
  result.reserve(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (kept[i]) result.push_back(items[i]);
  }
  return result;
}

}  // namespace sgraph
