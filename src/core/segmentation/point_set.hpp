#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/segmentation/plane_segmenter.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/util/rng.hpp"

namespace sgraph {

/// A plane in single precision, for tests of many points.
struct PlaneF {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  float d = 0;

  PlaneF() = default;
  explicit PlaneF(const Plane& plane) : normal(plane.normal.cast<float>()), d(static_cast<float>(plane.d)) {}
  [[nodiscard]] Plane exact() const { return {normal.cast<double>().normalized(), d}; }
  [[nodiscard]] float distance(const Eigen::Vector3f& p) const { return normal.dot(p) + d; }
};

/// Points coordinate by coordinate, so that tests against a plane run several at a time; with the viewpoint each was seen from. Neighbours in space
/// are mostly neighbours in the arrays: a plane passes by most blocks of them.
struct PointSet {
  static constexpr std::size_t block_size = 64;
  struct Block {
    Eigen::Vector3f center = Eigen::Vector3f::Zero();
    float radius = 0;
  };

  std::vector<float> x, y, z;
  std::vector<float> closeness;  ///< one over the distance to its viewpoint [1/m]
  std::vector<std::uint8_t> view;
  std::vector<std::uint32_t> index;  ///< in the cloud
  std::vector<Block> blocks;         ///< balls around 64 points each, by bound_blocks()

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] Eigen::Vector3f position(std::size_t i) const { return {x[i], y[i], z[i]}; }
  [[nodiscard]] float distance(const PlaneF& plane, std::size_t i) const {
    return plane.normal.x() * x[i] + plane.normal.y() * y[i] + plane.normal.z() * z[i] + plane.d;
  }
  void reserve(std::size_t count);
  void add(const Eigen::Vector3f& p, float one_over_distance, std::uint8_t from, std::uint32_t at);
  void bound_blocks();
  /// Drops the points whose flag isn't set; the others keep their order.
  void keep(const std::vector<char>& flags);
};

/// The finite points of the cloud in an order that keeps neighbours together, each with the viewpoint nearest in time. At most 256 viewpoints.
PointSet point_set(const Cloud& cloud, const std::vector<Viewpoint>& viewpoints);

/// How the viewpoints lie to a plane.
class Facing {
 public:
  Facing(const PlaneF& plane, const std::vector<Eigen::Vector3f>& viewpoints) : distances_(viewpoints.size()) {
    for (std::size_t k = 0; k < viewpoints.size(); ++k) distances_[k] = plane.distance(viewpoints[k]);
    all_ = *std::min_element(distances_.begin(), distances_.end()) > 0;
  }
  /// Whether the normal points to all viewpoints, to this one.
  [[nodiscard]] bool all() const { return all_; }
  [[nodiscard]] bool from(std::uint8_t viewpoint) const { return distances_[viewpoint] > 0; }
  /// Cosine of the angle between the normal and the ray to the i-th point, taken to lie on the plane; at most 1.
  [[nodiscard]] float cosine(const PointSet& points, std::size_t i) const {
    return std::min(std::abs(distances_[points.view[i]]) * points.closeness[i], 1.0F);
  }

 private:
  std::vector<float> distances_;
  bool all_ = false;
};

/// Truncated quadratic score of a plane: near 1 for a point on it, 0 at `threshold`, down to -1 for points just beside it, 0 for the rest. A thin
/// sheet scores about its number of points; a plane laid through a volume of clutter scores below 0. Points that the plane doesn't face count
/// nothing.
float score(const PointSet& points, const PlaneF& plane, float threshold, const Facing& facing);

/// Positions in the set of the points within `threshold` of the plane that it faces, in order.
void collect(const PointSet& points, const PlaneF& plane, float threshold, const Facing& facing, std::vector<std::uint32_t>& inliers);

/// Sum of [p; 1][p; 1]^T.
Eigen::Matrix4d scatter_of(const PointSet& points, const std::vector<std::uint32_t>& which);

/// A number from 0 to bound - 1.
inline std::size_t draw(RandomStream& random, std::size_t bound) {
  return std::min(static_cast<std::size_t>(random.next_uniform() * static_cast<double>(bound)), bound - 1);
}

/// A number that depends on every coordinate of the points.
std::uint64_t fingerprint(const PointSet& points);

}  // namespace sgraph
