#include "point_set.hpp"

#include <cmath>
#include <cstring>

#include <Eigen/Geometry>

namespace sgraph {
namespace {

using Block = Eigen::Array<float, PointSet::block_size, 1>;
constexpr float score_reach = 2.2361F;  // points beyond so many thresholds count nothing

Eigen::Map<const Block> block_of(const std::vector<float>& values, std::size_t first) { return Eigen::Map<const Block>(values.data() + first); }

// Of the square of the distance in units of the threshold.
float score_of(float u) { return std::max(std::max(1.0F - u, -1.0F), std::min(0.5F * (u - 5.0F), 0.0F)); }

// Calls f(first, last) for each block of points that may lie within `reach` of the plane.
template <class F>
void for_blocks_near(const PointSet& points, const PlaneF& plane, float reach, const F& f) {
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    if (std::abs(plane.distance(points.blocks[b].center)) > points.blocks[b].radius + reach) continue;
    f(b * PointSet::block_size, std::min((b + 1) * PointSet::block_size, points.size()));
  }
}

float score_facing_all(const PointSet& points, const PlaneF& plane, float threshold) {
  const float scale = 1.0F / threshold;
  const Eigen::Vector3f n = plane.normal * scale;
  const float d = plane.d * scale;
  float sum = 0;
  for_blocks_near(points, plane, score_reach * threshold, [&](std::size_t i, std::size_t last) {
    if (last - i == PointSet::block_size) {
      const Block u = (n.x() * block_of(points.x, i) + n.y() * block_of(points.y, i) + n.z() * block_of(points.z, i) + d).square();
      sum += (1.0F - u).max(-1.0F).max((0.5F * (u - 5.0F)).min(0.0F)).sum();
      return;
    }
    for (; i < last; ++i) {
      const float r = n.x() * points.x[i] + n.y() * points.y[i] + n.z() * points.z[i] + d;
      sum += score_of(r * r);
    }
  });
  return sum;
}

// Order of the points along a Z-order curve through cells of 0.8 m; within a cell as they came.
std::vector<std::uint32_t> spatial_order(const Cloud& cloud) {
  const auto spread = [](float value) {  // eight bits, three apart
    auto bits = static_cast<std::uint32_t>(std::min(std::max(value * 1.25F + 128.0F, 0.0F), 255.0F));
    bits = (bits | bits << 8) & 0x00F00FU;
    bits = (bits | bits << 4) & 0x0C30C3U;
    return (bits | bits << 2) & 0x249249U;
  };
  struct Entry {
    std::uint32_t key, index;
  };
  std::vector<Entry> entries, sorted;
  entries.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point& p = cloud.points[i];
    if (!std::isfinite(p.x + p.y + p.z)) continue;
    entries.push_back({spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2, static_cast<std::uint32_t>(i)});
  }
  sorted.resize(entries.size());
  for (const int shift : {0, 12}) {  // radix sort by two digits of twelve bits
    std::vector<std::uint32_t> place(4097, 0);
    for (const Entry& e : entries) ++place[(e.key >> shift & 4095U) + 1];
    for (std::size_t k = 1; k < place.size(); ++k) place[k] += place[k - 1];
    for (const Entry& e : entries) sorted[place[e.key >> shift & 4095U]++] = e;
    entries.swap(sorted);
  }
  std::vector<std::uint32_t> order;
  order.reserve(entries.size());
  for (const Entry& e : entries) order.push_back(e.index);
  return order;
}

}  // namespace

void PointSet::reserve(std::size_t count) {
  x.reserve(count);
  y.reserve(count);
  z.reserve(count);
  closeness.reserve(count);
  view.reserve(count);
  index.reserve(count);
}

void PointSet::add(const Eigen::Vector3f& p, float one_over_distance, std::uint8_t from, std::uint32_t at) {
  x.push_back(p.x());
  y.push_back(p.y());
  z.push_back(p.z());
  closeness.push_back(one_over_distance);
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
    closeness[next] = closeness[i];
    view[next] = view[i];
    index[next] = index[i];
    ++next;
  }
  x.resize(next);
  y.resize(next);
  z.resize(next);
  closeness.resize(next);
  view.resize(next);
  index.resize(next);
  bound_blocks();
}

void PointSet::bound_blocks() {
  blocks.resize((size() + block_size - 1) / block_size);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    Eigen::AlignedBox3f box;
    const std::size_t last = std::min((b + 1) * block_size, size());
    for (std::size_t i = b * block_size; i < last; ++i) box.extend(position(i));
    // A little more, for the rounding of the planes' distances.
    blocks[b] = {box.center(), 0.5F * box.diagonal().norm() * 1.0001F + 1e-4F};
  }
}

PointSet point_set(const Cloud& cloud, const std::vector<Viewpoint>& viewpoints) {
  PointSet set;
  set.reserve(cloud.size());
  std::size_t nearest = 0;  // points come nearly in order of time: the search starts at the last point's viewpoint
  for (const std::uint32_t i : spatial_order(cloud)) {
    const Point& p = cloud.points[i];
    const double time = std::isfinite(p.time) ? p.time : 0.0;
    const auto gap = [&](std::size_t k) { return std::abs(viewpoints[k].time - time); };
    while (nearest + 1 < viewpoints.size() && gap(nearest + 1) < gap(nearest)) ++nearest;
    while (nearest > 0 && gap(nearest - 1) <= gap(nearest)) --nearest;
    const float distance = (p.position() - viewpoints[nearest].position.cast<float>()).norm();
    set.add(p.position(), 1.0F / std::max(distance, 1e-3F), static_cast<std::uint8_t>(nearest), i);
  }
  set.bound_blocks();
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
  for_blocks_near(points, plane, threshold, [&](std::size_t i, std::size_t last) {
    for (; i < last; ++i) {
      if (std::abs(points.distance(plane, i)) <= threshold && facing.from(points.view[i])) inliers.push_back(static_cast<std::uint32_t>(i));
    }
  });
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
