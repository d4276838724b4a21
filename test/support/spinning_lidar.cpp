#include "spinning_lidar.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph::test {

std::vector<double> SpinningLidar::vlp16() { return {-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15}; }

std::vector<double> SpinningLidar::evenly(double low, double high, int count) {
  std::vector<double> angles;
  for (int i = 0; i < count; ++i) angles.push_back(low + (high - low) * i / (count - 1));
  return angles;
}

Cloud SpinningLidar::scan(double stamp) const {
  Cloud cloud;
  cloud.stamp = Stamp::from_seconds(stamp);
  cloud.frame = "velodyne";
  const auto lasers = static_cast<int>(elevations_deg.size());
  std::vector<double> sorted = elevations_deg;
  std::sort(sorted.begin(), sorted.end());
  const Eigen::Vector3d low(-3.2, -2.5, -1.2), high(4.8, 3.5, 1.6);
  for (int column = 0; column < columns; ++column) {
    for (int laser = 0; laser < lasers; ++laser) {
      const double fraction = (column + static_cast<double>(laser) / lasers / 1.5) / columns;
      const double azimuth = begin_deg * M_PI / 180 + (clockwise ? -2 : 2) * M_PI * fraction;
      const double elevation = elevations_deg[static_cast<std::size_t>(laser)] * M_PI / 180;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Eigen::Vector3d origin(0, 0, vertical_offsets.empty() ? 0 : vertical_offsets[static_cast<std::size_t>(laser)]);
      double range = 1e9;
      for (int axis = 0; axis < 3; ++axis) {
        const double wall = ray[axis] > 0 ? high[axis] : low[axis];
        if (std::abs(ray[axis]) > 1e-9) range = std::min(range, (wall - origin[axis]) / ray[axis]);
      }
      Point point;
      point.set_position((origin + range * ray).cast<float>());
      point.intensity = 50;
      point.time = static_cast<float>((fraction - 1) * turn);
      point.ring = static_cast<std::uint16_t>(std::lower_bound(sorted.begin(), sorted.end(), elevations_deg[static_cast<std::size_t>(laser)]) -
                                              sorted.begin());
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

}  // namespace sgraph::test
