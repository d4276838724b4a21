#include "point_set.hpp"

#include <cmath>
#include <cstring>

namespace sgraph {
namespace {

constexpr Eigen::Index block = 64;
using Block = Eigen::Array<float, block, 1>;

Eigen::Map<const Block> block_of(const std::vector<float>& values, std::size_t first) { return Eigen::Map<const Block>(values.data() + first); }

// Of the square of the distance in units of the threshold.
float score_of(float u) { return std::max(std::max(1.0F - u, -1.0F), std::min(0.5F * (u - 5.0F), 0.0F)); }

float score_facing_all(const PointSet& points, const PlaneF& plane, float threshold) {
  const float scale = 1.0F / threshold;
  const Eigen::Vector3f n = plane.normal * scale;
  const float d = plane.d * scale;
  float sum = 0;
  std::size_t i = 0;
  for (; i + block <= points.size(); i += block) {
    const Block u = (n.x() * block_of(points.x, i) + n.y() * block_of(points.y, i) + n.z() * block_of(points.z, i) + d).square();
    sum += (1.0F - u).max(-1.0F).max((0.5F * (u - 5.0F)).min(0.0F)).sum();
  }
  for (; i < points.size(); ++i) {
    const float r = n.x() * points.x[i] + n.y() * points.y[i] + n.z() * points.z[i] + d;
    sum += score_of(r * r);
  }
  return sum;
}

}  // namespace

void PointSet::reserve(std::size_t count) {
  x.reserve(count);
  y.reserve(count);
  z.reserve(count);
  view.reserve(count);
  index.reserve(count);
}

void PointSet::add(const Eigen::Vector3f& p, std::uint8_t from, std::uint32_t at) {
  x.push_back(p.x());
  y.push_back(p.y());
  z.push_back(p.z());
  view.push_back(from);
  index.push_back(at);
}

void PointSet::keep(const std::vector<char>& flags) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    if (!flags[i]) continue;
    x[next] = x[i];
    y[next] = y[i];
    z[next] = z[i];
    view[next] = view[i];
    index[next] = index[i];
    ++next;
  }
  x.resize(next);
  y.resize(next);
  z.resize(next);
  view.resize(next);
  index.resize(next);
}

PointSet point_set(const Cloud& cloud, const std::vector<Viewpoint>& viewpoints) {
  PointSet set;
  set.reserve(cloud.size());
  std::size_t nearest = 0;  // points come nearly in order of time: the search starts at the last point's viewpoint
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point& p = cloud.points[i];
    if (!std::isfinite(p.x + p.y + p.z)) continue;
    const double time = std::isfinite(p.time) ? p.time : 0.0;
    const auto gap = [&](std::size_t k) { return std::abs(viewpoints[k].time - time); };
    while (nearest + 1 < viewpoints.size() && gap(nearest + 1) < gap(nearest)) ++nearest;
    while (nearest > 0 && gap(nearest - 1) <= gap(nearest)) --nearest;
    set.add(p.position(), static_cast<std::uint8_t>(nearest), static_cast<std::uint32_t>(i));
  }
  return set;
}

float score(const PointSet& points, const PlaneF& plane, float threshold, const Facing& facing) {
  if (facing.all()) return score_facing_all(points, plane, threshold);
  float sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!facing.from(points.view[i])) continue;
    const float r = points.distance(plane, i) / threshold;
    sum += score_of(r * r);
  }
  return sum;
}

void collect(const PointSet& points, const PlaneF& plane, float threshold, const Facing& facing, std::vector<std::uint32_t>& inliers) {
  inliers.clear();
  std::size_t i = 0;
  const auto test = [&](std::size_t k) {
    if (std::abs(points.distance(plane, k)) <= threshold && facing.from(points.view[k])) inliers.push_back(static_cast<std::uint32_t>(k));
  };
  for (; i + block <= points.size(); i += block) {
    const auto r =
        plane.normal.x() * block_of(points.x, i) + plane.normal.y() * block_of(points.y, i) + plane.normal.z() * block_of(points.z, i) + plane.d;
    if (r.abs().minCoeff() > threshold) continue;  // most blocks, as neighbours in a scan are neighbours in space
    for (std::size_t k = i; k < i + block; ++k) test(k);
  }
  for (; i < points.size(); ++i) test(i);
}

Eigen::Matrix4d scatter_of(const PointSet& points, const std::vector<std::uint32_t>& which) {
  double x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (const std::uint32_t i : which) {
    const double px = points.x[i], py = points.y[i], pz = points.z[i];
    x += px;
    y += py;
    z += pz;
    xx += px * px;
    xy += px * py;
    xz += px * pz;
    yy += py * py;
    yz += py * pz;
    zz += pz * pz;
  }
  Eigen::Matrix4d scatter;
  scatter << xx, xy, xz, x, xy, yy, yz, y, xz, yz, zz, z, x, y, z, static_cast<double>(which.size());
  return scatter;
}

std::uint64_t fingerprint(const PointSet& points) {
  std::uint64_t hash = points.size();
  const auto mix = [&hash](float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    hash = (hash ^ bits) * 0x100000001B3ULL;
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    mix(points.x[i]);
    mix(points.y[i]);
    mix(points.z[i]);
  }
  return hash;
}

}  // namespace sgraph
