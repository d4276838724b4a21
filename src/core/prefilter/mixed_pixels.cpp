#include "mixed_pixels.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace sgraph {
namespace {

// Five sigmas of a range that scatters by 2 cm: smaller steps along a ring can't be told from those along a surface seen at a grazing angle.
constexpr float apart = 0.1F;  // [m]

// Neighbours on a ring are a firing apart, 0.1 to 0.4 degrees; farther off, there were firings without a return between them.
constexpr float widest_step = 0.014F;  // [rad]

// On a plane, inverse ranges of evenly spaced beams go on by equal steps; a jump's step is a multiple of the one before.
constexpr float even = 0.5F;

// The last five points of a ring, oldest first.
struct Window {
  std::array<const Point*, 5> points{};
  std::array<float, 5> ranges{};

  void push(const Point& p, float range) {
    for (std::size_t k = 1; k < points.size(); ++k) {
      points[k - 1] = points[k];
      ranges[k - 1] = ranges[k];
    }
    points.back() = &p;
    ranges.back() = range;
  }

  [[nodiscard]] bool are_neighbours() const {
    for (std::size_t k = 1; k < points.size(); ++k) {
      const float cosine = points[k]->position().dot(points[k - 1]->position()) / (ranges[k] * ranges[k - 1]);
      if (cosine < 1 - 0.5F * widest_step * widest_step) return false;
    }
    return true;
  }

  // Whether the middle point floats between the two before and the two after it.
  [[nodiscard]] bool is_mixed() const {
    const float in = ranges[2] - ranges[1], out = ranges[3] - ranges[2];
    if (std::abs(in) < apart || std::abs(out) < apart || (in > 0) != (out > 0) || points[0] == nullptr) return false;
    const auto step = [this](std::size_t k) { return 1 / ranges[k + 1] - 1 / ranges[k]; };
    return step(0) / step(1) < even && step(3) / step(2) < even && are_neighbours();
  }
};

}  // namespace

std::vector<std::uint8_t> mixed_pixels(const Cloud& raw) {
  std::vector<std::uint8_t> mixed(raw.size(), 0);
  std::vector<Window> rings;
  for (const Point& p : raw.points) {
    const float range = p.position().norm();
    if (!std::isfinite(range) || !(range > 0)) continue;
    if (p.ring >= rings.size()) rings.resize(p.ring + std::size_t{1});
    Window& window = rings[p.ring];
    window.push(p, range);
    if (window.is_mixed()) mixed[static_cast<std::size_t>(window.points[2] - raw.points.data())] = 1;
  }
  return mixed;
}

}  // namespace sgraph
