#include "sgraph_slam/core/registration/surface_map.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

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
constexpr int settled_count = 50;

// Enough new points to be worth another fit: every change while there are few, then every tenth part.
bool needs_refit(int count, int fitted) { return count > fitted + fitted / 10; }

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

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

SurfaceMap::SurfaceMap(const SurfaceMapParams& params) : params_(params), flat_variance_(params.flat_sigma * params.flat_sigma) {
  double edge = params.voxel;
  for (int i = 0; i < params.levels; ++i, edge *= 0.5) levels_.push_back({edge, VoxelIndex(edge), {}, {}});
  edge = params.voxel;
  for (int i = 0; i < params.wide_levels; ++i) {
    edge *= 2;
    levels_.push_back({edge, VoxelIndex(edge), {}, {}});
  }
}

std::size_t SurfaceMap::voxel_count() const {
  std::size_t n = 0;
  for (const Level& level : levels_) n += level.voxels.size();
  return n;
}

std::vector<Surface> SurfaceMap::surfaces() const {
  std::vector<Surface> all;
  for (const Voxel& voxel : levels_.front().voxels) {
    for (const Face& face : voxel.faces) {
      if (face.flat) all.push_back(face.surface);
    }
  }
  return all;
}

SurfaceMap::Face* SurfaceMap::face_for(Voxel& voxel, const Eigen::Vector3d& ray) const {
  Face& first = voxel.faces[0];
  if (!params_.two_faces || !first.flat) return &first;
  const double side = first.surface.normal.dot(ray);
  if (side > grazing) return &first;
  return side < -grazing ? &voxel.faces[1] : nullptr;
}

void SurfaceMap::insert(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, const std::optional<Eigen::Vector3f>& normal, Placing placing) {
  const Eigen::Vector3d ray = (sensor - point).normalized();
  for (Level& level : levels_) {
    const std::uint32_t i = level.index.find_or_add(level.index.key(point));
    if (i == level.voxels.size()) level.voxels.push_back({point, {}});
    Voxel& voxel = level.voxels[i];
    Face* face = face_for(voxel, ray);
    if (face == nullptr || face->count >= params_.max_points) continue;
    const bool settled = placing == Placing::sure && face->flat && face->count >= settled_count;
    if (settled && std::pow(face->surface.normal.dot(point - face->surface.mean), 2) > 4 * flat_variance_) continue;
    const Eigen::Vector3d p = point - voxel.origin;
    face->sum += p;
    add_outer_product(p, face->outer);
    face->seen_from += ray.cast<float>();
    add_outer_product<float>(ray.cast<float>(), face->rays);
    if (normal) {
      add_outer_product<float>(*normal, face->normals);
      ++face->with_normal;
    }
    ++face->count;
    if (!face->changed && face->count >= params_.min_points && needs_refit(face->count, face->fitted)) {
      face->changed = true;
      level.changed.push_back(i);
    }
  }
}

void SurfaceMap::fit(Face& face, const Eigen::Vector3d& origin, double edge) const {
  const double n = face.count;
  const Eigen::Vector3d mean = face.sum / n;
  const Eigen::Matrix3d covariance = (symmetric(face.outer) - n * mean * mean.transpose()) / (n - 1);
  // Noise lies along the rays: where they graze the surface it leans the Gaussian towards them. What it adds is known, so it is taken out.
  const Eigen::Matrix3d along_rays = symmetric(face.rays) / n;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance - range_variance_ * along_rays);
  face.surface.mean = origin + mean;
  const auto describe = [&] {
    face.surface.normal = solver.eigenvectors().col(0);
    face.surface.variance = std::max(0.0, face.surface.normal.dot(covariance * face.surface.normal));
    face.incidence = static_cast<float>(face.surface.normal.dot(along_rays * face.surface.normal));
    if (face.surface.normal.dot(face.seen_from.cast<double>()) < 0) face.surface.normal *= -1;
    face.ratio = static_cast<float>(face.surface.variance / std::max(1e-12, solver.eigenvalues()[1]));
  };
  describe();
  // A stripe or two of a ring say little of the lean about them.
  bool known = 0.5 * edge * std::sqrt(face.ratio / n) < known_at_edge;
  if (!known && 2 * face.with_normal >= face.count) {
    // But the rings beside it did, when they were seen: each point stands for a disc.
    const Eigen::Matrix3d normals = symmetric(face.normals) / static_cast<double>(face.with_normal);
    const double radius = 0.25 * edge;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> agreement;
    agreement.computeDirect(normals, Eigen::EigenvaluesOnly);
    const double off = std::sqrt(std::max(0.0, 1 - agreement.eigenvalues()[2]) / face.with_normal);  // [rad] of their mean
    if (agreement.eigenvalues()[2] > same_normals && 0.5 * edge * off < known_at_edge) {
      solver.computeDirect(covariance - range_variance_ * along_rays + radius * radius * (Eigen::Matrix3d::Identity() - normals));
      describe();
      known = true;
    }
  }
  const double by_noise = noise_share * noise_share * range_variance_ * static_cast<double>(face.incidence);
  face.flat = known && face.ratio < params_.flat_ratio && face.surface.variance < std::max(flat_variance_, by_noise);
  face.fitted = face.count;
}

void SurfaceMap::update() {
  const bool first = noise_ == 0;
  fit_changed();
  update_noise();
  // The first scan's Gaussians were fitted before the noise was known.
  if (first && noise_ > 0) fit_changed();
  for (Level& level : levels_) {
    for (const std::uint32_t i : level.changed) {
      for (Face& face : level.voxels[i].faces) face.changed = false;
    }
    level.changed.clear();
  }
}

void SurfaceMap::fit_changed() {
  for (Level& level : levels_) {
    for (const std::uint32_t i : level.changed) {
      Voxel& voxel = level.voxels[i];
      for (Face& face : voxel.faces) {
        if (face.changed) fit(face, voxel.origin, level.edge);
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
    const Face& face = level.voxels[i].faces[0];
    if (face.fitted < params_.min_points || face.ratio >= params_.flat_ratio) continue;
    variances.push_back(face.surface.variance);
    if (face.incidence > steep) along_ray.push_back(face.surface.variance / static_cast<double>(face.incidence));
  }
  if (variances.size() < 10) return;
  noise_ = std::sqrt(median(variances));
  if (along_ray.size() >= 10) range_variance_ = median(along_ray);
  const double limit = std::max(params_.flat_sigma, noise_share * noise_);
  flat_variance_ = limit * limit;
}

// The face of the voxel around `at` that looks at the sensor and is nearer to `point` than the gate.
const Surface* SurfaceMap::match_in(const Level& level, const Eigen::Vector3d& at, const Eigen::Vector3d& point, const Eigen::Vector3d& sensor,
                                    double gate) const {
  const std::uint32_t i = level.index.find(level.index.key(at));
  if (i == VoxelIndex::none) return nullptr;
  for (const Face& face : level.voxels[i].faces) {
    if (!face.flat) continue;
    const Surface& surface = face.surface;
    const Eigen::Vector3d ray = sensor - point;
    if (params_.two_faces && surface.normal.dot(ray) < grazing * ray.norm()) continue;
    if (std::abs(surface.normal.dot(point - surface.mean)) < gate) return &surface;
  }
  return nullptr;
}

const Surface* SurfaceMap::match(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, double gate, Reach reach) const {
  const std::size_t levels = reach == Reach::own ? static_cast<std::size_t>(params_.levels) : levels_.size();
  for (std::size_t k = 0; k < levels; ++k) {
    if (const Surface* surface = match_in(levels_[k], point, point, sensor, gate)) return surface;
  }
  if (reach != Reach::neighbours) return nullptr;
  const double edge = params_.voxel * std::pow(2.0, params_.wide_levels);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-0.5 * edge, 0.5 * edge}) {
      if (const Surface* surface = match_in(levels_.back(), point + side * Eigen::Vector3d::Unit(axis), point, sensor, gate)) return surface;
    }
  }
  return nullptr;
}

}  // namespace sgraph
