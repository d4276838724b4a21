#include "segment_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sgraph_slam/core/math/noise.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/segmentation/plane_fit.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

constexpr double least_sigma = 1e-3;       // no sensor is better than a millimetre
constexpr std::uint16_t most_rings = 256;  // ring numbers beyond are none
constexpr float most_cells = 64.0F;        // patches along one axis: larger surfaces get larger ones

// How a point's distance from the plane changes with its beam's range and elevation.
struct BeamShare {
  double by_range = 0;
  double by_elevation = 0;  // [m/rad]
};

BeamShare share_of(const Eigen::Vector3f& normal, const Eigen::Vector3f& p, const Eigen::Vector3f& eye) {
  const Eigen::Vector3f ray = p - eye;
  const float flat = ray.head<2>().norm();
  BeamShare share;
  share.by_range = static_cast<double>(normal.dot(ray) / std::max(ray.norm(), 1e-3F));
  if (flat > 1e-3F) share.by_elevation = static_cast<double>(normal.z() * flat - ray.z() * normal.head<2>().dot(ray.head<2>()) / flat);
  return share;
}

}  // namespace

double usual_sigma(const std::vector<PlaneSegment>& segments) {
  std::vector<double> sigmas;
  for (const PlaneSegment& segment : segments) {
    if (std::isfinite(segment.sigma)) sigmas.push_back(segment.sigma);
  }
  return upper_median(std::move(sigmas));
}

Eigen::Matrix3d segment_covariance(const Cloud& cloud, const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints,
                                   const FlatSurface& surface, double usual) {
  const Eigen::Matrix<double, 3, 2> basis = tangent_basis(surface.plane.normal);
  const Eigen::Matrix<float, 2, 3> on_plane = basis.transpose().cast<float>();
  const Eigen::Vector3f normal = surface.plane.normal.cast<float>();

  Eigen::AlignedBox2f box;
  for (const std::uint32_t i : surface.members) box.extend(Eigen::Vector2f(on_plane * points.position(i)));
  const float edge = std::max(static_cast<float>(noise::patch), box.sizes().maxCoeff() / (most_cells - 1));
  const auto columns = static_cast<std::size_t>(box.sizes().x() / edge) + 1;
  const auto rows = static_cast<std::size_t>(box.sizes().y() / edge) + 1;

  std::vector<Eigen::Vector3d> patches(columns * rows, Eigen::Vector3d::Zero());
  std::vector<Eigen::Vector3d> ranges;  // by ring
  std::vector<Eigen::Vector3d> elevations;
  for (const std::uint32_t i : surface.members) {
    const Eigen::Vector3f p = points.position(i);
    const Eigen::Vector2f at = on_plane * p;
    const Eigen::Vector3d jacobian(static_cast<double>(at.x()), static_cast<double>(at.y()), 1.0);
    const Eigen::Vector2f cell = (at - box.min()) / edge;
    patches[static_cast<std::size_t>(cell.y()) * columns + static_cast<std::size_t>(cell.x())] += jacobian;
    const std::size_t ring = std::min(cloud.points[points.index[i]].ring, most_rings);
    if (ring >= ranges.size()) {
      ranges.resize(ring + 1, Eigen::Vector3d::Zero());
      elevations.resize(ring + 1, Eigen::Vector3d::Zero());
    }
    const BeamShare share = share_of(normal, p, viewpoints[points.view[i]]);
    ranges[ring] += share.by_range * jacobian;
    elevations[ring] += share.by_elevation * jacobian;
  }

  // Three degrees of freedom went into the plane.
  const double n = surface.scatter(3, 3);
  const double white = std::max(least_sigma, surface.sigma * std::sqrt(n / (n - 3)));
  const Eigen::Matrix3d inverse = plane_covariance(surface.plane, surface.scatter, 1.0);
  const double rough = std::max(0.0, surface.sigma * surface.sigma - usual * usual);
  const double by_patch = std::sqrt(noise::surface * noise::surface + rough);
  SharedErrors<3> shared;
  for (const Eigen::Vector3d& sum : patches) shared.add(sum, by_patch);
  for (const Eigen::Vector3d& sum : ranges) shared.add(sum, noise::beam_range);
  for (const Eigen::Vector3d& sum : elevations) shared.add(sum, noise::beam_elevation);
  const Eigen::Matrix3d covariance = white * white * inverse + shared.covariance(inverse);
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace sgraph
