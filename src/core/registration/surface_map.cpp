#include "sgraph_slam/core/registration/surface_map.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

// A ray closer to the surface than this (about 4 degrees) doesn't tell which side it comes from.
constexpr double grazing = 0.07;

// How much thicker than by the sensor's noise a flat Gaussian may be.
constexpr double noise_share = 1.5;

// A Gaussian is used when its plane is known this well half an edge of its voxel away from its mean [m].
constexpr double known_at_edge = 0.01;

// Largest eigenvalue of the mean outer product of unit normals that agree (rms about 6 degrees).
constexpr double same_normals = 0.99;

// Square of the cosine between rays and normal above which points tell of the noise along the ray.
constexpr float steep = 0.25F;

// Points after which a flat Gaussian takes no more of those beside it. A metre of wall with a hand's breadth of the floor at its foot is flat enough
// to be used, and leans; in a corridor all of them lean the same way, and the map twists. The first points are taken as they come: nothing is known
// yet.
constexpr std::uint32_t settled_count = 50;

// Enough new points to be worth another fit: every change while there are few, then every tenth part.
bool needs_refit(std::uint32_t count, std::uint32_t fitted) { return count > fitted + fitted / 10; }

template <typename Scalar>
void add_outer_product(const Eigen::Matrix<Scalar, 3, 1>& p, std::array<Scalar, 6>& sum) {
  sum[0] += p.x() * p.x();
  sum[1] += p.x() * p.y();
  sum[2] += p.x() * p.z();
  sum[3] += p.y() * p.y();
  sum[4] += p.y() * p.z();
  sum[5] += p.z() * p.z();
}

template <typename Scalar>
Eigen::Matrix3d symmetric(const std::array<Scalar, 6>& o) {
  Eigen::Matrix<Scalar, 3, 3> m;
  m << o[0], o[1], o[2], o[1], o[3], o[4], o[2], o[4], o[5];
  return m.template cast<double>();
}

}  // namespace

SurfaceMap::SurfaceMap(const SurfaceMapParams& params) : params_(params), flat_variance_(params.flat_sigma * params.flat_sigma) {
  const auto add = [this](double edge, int halvings) { levels_.push_back({edge, halvings, VoxelIndex(edge), {}, {}, {}}); };
  double edge = params.voxel;
  for (int i = 0; i < params.levels; ++i, edge *= 0.5) add(edge, params.levels - 1 - i);
  inverse_finest_ = 1.0 / levels_.back().edge;
  edge = params.voxel;
  for (int i = 0; i < params.wide_levels; ++i) add(edge *= 2, params.levels + i);
}

std::size_t SurfaceMap::voxel_count() const {
  std::size_t n = 0;
  for (const Level& level : levels_) n += level.voxels.size();
  return n;
}

std::vector<Surface> SurfaceMap::surfaces(std::size_t first) const {
  std::vector<Surface> all;
  const Level& level = levels_.front();
  for (std::size_t i = 2 * first; i < level.surfaces.size(); ++i) {
    if (level.voxels[i / 2].sides[i % 2].flat) all.push_back(level.surfaces[i]);
  }
  return all;
}

// The side of the voxel that a point belongs to by the ray to its sensor; -1 when that grazes the surface.
int SurfaceMap::side_for(const Level& level, std::uint32_t voxel, const Eigen::Vector3d& ray) const {
  if (!params_.two_faces || !level.voxels[voxel].sides[0].flat) return 0;
  const double side = level.surfaces[2 * static_cast<std::size_t>(voxel)].normal.dot(ray);
  if (side > grazing) return 0;
  return side < -grazing ? 1 : -1;
}

void SurfaceMap::insert(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, const std::optional<Eigen::Vector3f>& normal, Placing placing) {
  const Eigen::Vector3d ray = (sensor - point).normalized();
  const VoxelIndex::Cell cell = VoxelIndex::cell(point, inverse_finest_);
  for (Level& level : levels_) {
    const std::uint64_t key = VoxelIndex::key(cell, level.halvings);
    const std::uint32_t i = level.index.find_or_add(key);
    if (i == level.voxels.size()) {
      level.voxels.push_back({key, point, {}});
      level.surfaces.resize(level.surfaces.size() + 2);
    }
    const int which = side_for(level, i, ray);
    if (which < 0) continue;
    Voxel& voxel = level.voxels[i];
    Side& side = voxel.sides[static_cast<std::size_t>(which)];
    if (side.count >= static_cast<std::uint32_t>(params_.max_points)) continue;
    const bool settled = placing == Placing::sure && side.flat && side.count >= settled_count;
    const Surface& surface = level.surfaces[2 * static_cast<std::size_t>(i) + static_cast<std::size_t>(which)];
    if (settled && std::pow(surface.distance(point), 2) > 4 * flat_variance_) continue;
    const Eigen::Vector3d p = point - voxel.origin;
    side.sum += p;
    add_outer_product(p, side.outer);
    side.seen_from += ray.cast<float>();
    add_outer_product<float>(ray.cast<float>(), side.rays);
    if (normal) {
      add_outer_product<float>(*normal, side.normals);
      ++side.with_normal;
    }
    ++side.count;
    if (!side.changed && side.count >= static_cast<std::uint32_t>(params_.min_points) && needs_refit(side.count, side.fitted)) {
      side.changed = true;
      level.changed.push_back(i);
    }
  }
}

void SurfaceMap::fit(Level& level, std::uint32_t index, int which) {
  Voxel& voxel = level.voxels[index];
  Side& side = voxel.sides[static_cast<std::size_t>(which)];
  Surface& surface = level.surfaces[2 * static_cast<std::size_t>(index) + static_cast<std::size_t>(which)];
  const double edge = level.edge;
  const double n = side.count;
  const Eigen::Vector3d mean = side.sum / n;
  const Eigen::Matrix3d covariance = (symmetric(side.outer) - n * mean * mean.transpose()) / (n - 1);
  // Noise lies along the rays: where they graze the surface it leans the Gaussian towards them. What it adds is known, so it is taken out.
  const Eigen::Matrix3d along_rays = symmetric(side.rays) / n;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance - range_variance_ * along_rays);
  surface.mean = voxel.origin + mean;
  const auto describe = [&] {
    surface.normal = solver.eigenvectors().col(0);
    surface.variance = std::max(0.0, surface.normal.dot(covariance * surface.normal));
    side.incidence = static_cast<float>(surface.normal.dot(along_rays * surface.normal));
    if (surface.normal.dot(side.seen_from.cast<double>()) < 0) surface.normal *= -1;
    surface.offset = -surface.normal.dot(surface.mean);
    side.ratio = static_cast<float>(surface.variance / std::max(1e-12, solver.eigenvalues()[1]));
  };
  describe();
  // A stripe or two of a ring say little of the lean about them.
  bool known = 0.5 * edge * std::sqrt(side.ratio / n) < known_at_edge;
  if (!known && 2 * side.with_normal >= side.count) {
    // But the rings beside it did, when they were seen: each point stands for a disc.
    const Eigen::Matrix3d normals = symmetric(side.normals) / static_cast<double>(side.with_normal);
    const double radius = 0.25 * edge;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> agreement;
    agreement.computeDirect(normals, Eigen::EigenvaluesOnly);
    const double off = std::sqrt(std::max(0.0, 1 - agreement.eigenvalues()[2]) / side.with_normal);  // [rad] of their mean
    if (agreement.eigenvalues()[2] > same_normals && 0.5 * edge * off < known_at_edge) {
      solver.computeDirect(covariance - range_variance_ * along_rays + radius * radius * (Eigen::Matrix3d::Identity() - normals));
      describe();
      known = true;
    }
  }
  const double by_noise = noise_share * noise_share * range_variance_ * static_cast<double>(side.incidence);
  side.flat = known && side.ratio < params_.flat_ratio && surface.variance < std::max(flat_variance_, by_noise);
  side.fitted = side.count;
  level.index.set_tag(voxel.key, static_cast<std::uint32_t>(voxel.sides[0].flat) | static_cast<std::uint32_t>(voxel.sides[1].flat) << 1);
}

void SurfaceMap::update() {
  const bool first = noise_ == 0;
  fit_changed();
  update_noise();
  // The first scan's Gaussians were fitted before the noise was known.
  if (first && noise_ > 0) fit_changed();
  for (Level& level : levels_) {
    for (const std::uint32_t i : level.changed) {
      for (Side& side : level.voxels[i].sides) side.changed = false;
    }
    level.changed.clear();
  }
}

void SurfaceMap::fit_changed() {
  for (Level& level : levels_) {
    for (const std::uint32_t i : level.changed) {
      for (const int which : {0, 1}) {
        if (level.voxels[i].sides[static_cast<std::size_t>(which)].changed) fit(level, i, which);
      }
    }
  }
}

void SurfaceMap::update_noise() {
  // Of the middle level: large enough to hold several stripes, small enough to be one surface. A sample keeps it cheap.
  const Level& level = levels_[static_cast<std::size_t>(params_.levels) / 2];
  std::vector<double> variances;
  std::vector<double> along_ray;
  const std::size_t step = 1 + level.voxels.size() / 500;
  for (std::size_t i = 0; i < level.voxels.size(); i += step) {
    const Side& side = level.voxels[i].sides[0];
    if (side.fitted < static_cast<std::uint32_t>(params_.min_points) || side.ratio >= params_.flat_ratio) continue;
    const double variance = level.surfaces[2 * i].variance;
    variances.push_back(variance);
    if (side.incidence > steep) along_ray.push_back(variance / static_cast<double>(side.incidence));
  }
  if (variances.size() < 10) return;
  noise_ = std::sqrt(upper_median(std::move(variances)));
  if (along_ray.size() >= 10) range_variance_ = upper_median(std::move(along_ray));
  const double limit = std::max(params_.flat_sigma, noise_share * noise_);
  flat_variance_ = limit * limit;
}

// The side of the cell's voxel that looks at the sensor and is nearer to the point than the gate.
const Surface* SurfaceMap::match_in(const Level& level, const VoxelIndex::Cell& cell, const Query& query) {
  const VoxelIndex::Entry entry = level.index.entry(VoxelIndex::key(cell, level.halvings));
  if (entry.tag == 0) return nullptr;
  for (std::uint32_t side = 0; side < 2; ++side) {
    if ((entry.tag >> side & 1U) == 0) continue;
    const Surface& surface = level.surfaces[2 * static_cast<std::size_t>(entry.index) + side];
    if (surface.normal.dot(query.ray) >= query.least_cosine && std::abs(surface.distance(query.point)) < query.gate) return &surface;
  }
  return nullptr;
}

const Surface* SurfaceMap::match(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, double gate, Reach reach) const {
  const Eigen::Vector3d ray = sensor - point;
  const Query query{point, ray, grazing * ray.norm(), gate};
  const VoxelIndex::Cell cell = VoxelIndex::cell(point, inverse_finest_);
  const std::size_t levels = reach == Reach::own ? static_cast<std::size_t>(params_.levels) : levels_.size();
  for (std::size_t k = 0; k < levels; ++k) {
    if (const Surface* surface = match_in(levels_[k], cell, query)) return surface;
  }
  if (reach != Reach::neighbours) return nullptr;
  const double edge = params_.voxel * std::pow(2.0, params_.wide_levels);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-0.5 * edge, 0.5 * edge}) {
      const VoxelIndex::Cell beside = VoxelIndex::cell(point + side * Eigen::Vector3d::Unit(axis), inverse_finest_);
      if (const Surface* surface = match_in(levels_.back(), beside, query)) return surface;
    }
  }
  return nullptr;
}

}  // namespace sgraph
