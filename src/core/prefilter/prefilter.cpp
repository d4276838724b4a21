#include "sgraph_slam/core/prefilter/prefilter.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "mixed_pixels.hpp"
#include "outliers.hpp"
#include "sgraph_slam/core/util/scattered_order.hpp"
#include "sgraph_slam/core/util/voxel_set.hpp"

namespace sgraph {
namespace {

double squared_range(const Point& p) {
  const double x = p.x, y = p.y, z = p.z;
  return x * x + y * y + z * z;
}

bool valid(const Point& p, double range2) { return range2 > 0 && std::isfinite(range2) && std::isfinite(p.time); }

struct Interval {
  double low2;
  double high2;  ///< squared ranges [m^2]
  [[nodiscard]] bool holds(double range2) const { return low2 <= range2 && range2 <= high2; }
};

// The interval narrowed to mean +- k sigma of the ranges within it (paper, Plane Extraction).
Interval narrowed(const Cloud& raw, const Interval& interval, double sigmas) {
  double count = 0, sum = 0, sum2 = 0;
  for (const Point& p : raw.points) {
    const double range2 = squared_range(p);
    if (!valid(p, range2) || !interval.holds(range2)) continue;
    count += 1;
    sum += std::sqrt(range2);
    sum2 += range2;
  }
  if (count == 0) return interval;
  const double mean = sum / count;
  const double sigma = std::sqrt(std::max(0.0, sum2 / count - mean * mean));
  const double low = std::max(0.0, mean - sigmas * sigma);
  const double high = mean + sigmas * sigma;
  return {std::max(interval.low2, low * low), std::min(interval.high2, high * high)};
}

}  // namespace

Prefilter::Prefilter(const PrefilterParams& params) : params_(params) {
  if (!(params.min_range < params.max_range)) throw std::runtime_error("prefilter.min_range must be below prefilter.max_range");
  const double cells = std::ldexp(1.0, VoxelSet::bits_per_axis - 1) - 1;
  if (params.leaf > 0 && params.max_range / params.leaf > cells) {
    throw std::runtime_error("prefilter.leaf is too small for prefilter.max_range: at most " + std::to_string(static_cast<int>(cells)) + " cells");
  }
}

FilteredScan Prefilter::process(const Cloud& raw) const {
  FilteredScan result;
  PrefilterCounts& counts = result.counts;
  counts.input = static_cast<int>(raw.size());
  Interval interval{params_.min_range * params_.min_range, params_.max_range * params_.max_range};
  if (params_.range_sigmas > 0) interval = narrowed(raw, interval, params_.range_sigmas);

  const std::vector<std::uint8_t> mixed = params_.keep_mixed_pixels ? std::vector<std::uint8_t>() : mixed_pixels(raw);
  const bool thin = params_.leaf > 0;
  VoxelSet taken(thin ? params_.leaf : 1.0, thin ? raw.size() : 0);
  auto cloud = std::make_shared<Cloud>();
  cloud->stamp = raw.stamp;
  cloud->frame = raw.frame;
  cloud->points = kept_scattered(raw.points, [&](const Point& p) {
    const double range2 = squared_range(p);
    if (!valid(p, range2)) {
      ++counts.invalid;
    } else if (!interval.holds(range2)) {
      ++counts.out_of_range;
    } else if (!mixed.empty() && mixed[static_cast<std::size_t>(&p - raw.points.data())] != 0) {
      ++counts.mixed;
    } else if (thin && !taken.insert(p.x, p.y, p.z)) {
      ++counts.voxel;
    } else {
      return true;
    }
    return false;
  });
  counts.outliers = remove_outliers(cloud->points, params_);
  cloud->points.shrink_to_fit();  // scans are kept by keyframes and by the odometry's window
  counts.kept = static_cast<int>(cloud->size());
  result.cloud = std::move(cloud);
  return result;
}

}  // namespace sgraph
