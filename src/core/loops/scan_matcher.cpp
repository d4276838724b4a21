#include "sgraph_slam/core/loops/scan_matcher.hpp"

#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <pcl/filters/voxel_grid.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_types.h>
#include <pcl/registration/ndt.h>

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr std::size_t min_points = 100;
constexpr double match_distance = 0.3;  // of a point from its nearest neighbour, to count as matched [m]
constexpr double point_sigma = 0.05;    // of a matched point along the surface's normal [m]
constexpr int normal_neighbours = 20;

PclCloud::Ptr thinned(const Cloud& cloud, double leaf) {
  auto all = std::make_shared<PclCloud>();
  all->reserve(cloud.size());
  for (const Point& p : cloud.points) {
    if (p.position().allFinite()) all->push_back({p.x, p.y, p.z});
  }
  auto thin = std::make_shared<PclCloud>();
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  const auto edge = static_cast<float>(leaf);
  grid.setLeafSize(edge, edge, edge);
  grid.setInputCloud(all);
  grid.filter(*thin);
  return thin;
}

// Normal of the surface around a target point; zero when it isn't flat.
Eigen::Vector3d normal_at(const PclCloud& target, const std::vector<int>& around) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const int i : around) mean += target[static_cast<std::size_t>(i)].getVector3fMap().cast<double>();
  mean /= static_cast<double>(around.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const int i : around) {
    const Eigen::Vector3d off = target[static_cast<std::size_t>(i)].getVector3fMap().cast<double>() - mean;
    spread += off * off.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  if (axes.eigenvalues()(0) > 0.03 * axes.eigenvalues()(1)) return Eigen::Vector3d::Zero();
  return axes.eigenvectors().col(0);
}

// The target's surfaces, for point-to-plane distances.
class Surfaces {
 public:
  explicit Surfaces(const PclCloud::Ptr& cloud) : cloud_(cloud), normals_(cloud->size()), known_(cloud->size(), false) { tree_.setInputCloud(cloud); }

  struct Hit {
    Eigen::Vector3d point;
    Eigen::Vector3d normal;  // zero where it isn't flat
    double squared_distance;
  };

  std::optional<Hit> nearest(const Eigen::Vector3d& p, double within) {
    const Eigen::Vector3f q = p.cast<float>();
    if (tree_.nearestKSearch(pcl::PointXYZ(q.x(), q.y(), q.z()), 1, index_, squared_) < 1 || squared_[0] > within * within) return std::nullopt;
    const auto i = static_cast<std::size_t>(index_[0]);
    const Hit hit{(*cloud_)[i].getVector3fMap().cast<double>(), normal(i), static_cast<double>(squared_[0])};
    return hit;
  }

 private:
  const Eigen::Vector3d& normal(std::size_t i) {
    if (!known_[i]) {
      tree_.nearestKSearch((*cloud_)[i], normal_neighbours, index_, squared_);
      normals_[i] = normal_at(*cloud_, index_);
      known_[i] = true;
    }
    return normals_[i];
  }

  PclCloud::Ptr cloud_;
  pcl::KdTreeFLANN<pcl::PointXYZ> tree_;
  std::vector<Eigen::Vector3d> normals_;
  std::vector<bool> known_;
  std::vector<int> index_;
  std::vector<float> squared_;
};

// Normal equations of the points' distances along the surfaces' normals, right perturbation of the pose; and fitness and overlap.
struct Residuals {
  Matrix6 information = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  std::size_t matched = 0;
  double squares = 0;
};

Residuals residuals(Surfaces& target, const PclCloud& source, const Pose& T_target_source, double within) {
  Residuals sum;
  const Eigen::Matrix3d R = T_target_source.matrix();
  for (const auto& point : source) {
    const Eigen::Vector3d p_source = point.getVector3fMap().cast<double>();
    const Eigen::Vector3d p = T_target_source * p_source;
    const auto hit = target.nearest(p, within);
    if (!hit) continue;
    ++sum.matched;
    sum.squares += hit->squared_distance;
    const Eigen::Vector3d n_source = R.transpose() * hit->normal;
    Vector6 row;
    row << p_source.cross(n_source), n_source;
    sum.information += row * row.transpose();
    sum.gradient += row * hit->normal.dot(p - hit->point);
  }
  return sum;
}

// Point-to-plane steps from where the normal distributions left off: their cells are coarser than a wall's noise.
void polish(Surfaces& target, const PclCloud& source, Pose* T_target_source) {
  for (const double within : {0.5, 0.4, 0.3, 0.3, 0.3}) {
    Residuals sum = residuals(target, source, *T_target_source, within);
    sum.information.diagonal().array() += 1.0;  // holds what no surface holds
    *T_target_source = *T_target_source * se3_exp(-sum.information.ldlt().solve(sum.gradient));
  }
}

void judge(Surfaces& target, const PclCloud& source, const LoopParams& params, ScanMatch* match) {
  const Residuals sum = residuals(target, source, match->T_target_source, match_distance);
  match->overlap = static_cast<double>(sum.matched) / static_cast<double>(source.size());
  match->fitness = sum.matched > 0 ? sum.squares / static_cast<double>(sum.matched) : 0;
  // A normal is fitted to its neighbours: what it is off by, they share.
  Matrix6 information = sum.information / (point_sigma * point_sigma * normal_neighbours);
  information.diagonal().array() += 1e-2;  // a direction that nothing holds: 10 rad, 10 m
  Vector6 floor;
  floor << Eigen::Vector3d::Constant(params.sigma_angle), Eigen::Vector3d::Constant(params.sigma_distance);
  match->covariance = information.inverse() + Matrix6(floor.cwiseAbs2().asDiagonal());
}

}  // namespace

const char* to_string(MatchFailure value) {
  switch (value) {
    case MatchFailure::none: return "matched";
    case MatchFailure::empty: return "too few points";
    case MatchFailure::not_converged: return "no convergence";
    case MatchFailure::fitness: return "matched points too far apart";
    case MatchFailure::overlap: break;
  }
  return "too few points have a match";
}

ScanMatch match_scans(const Cloud& target, const Cloud& source, const Pose& guess_T_target_source, const LoopParams& params) {
  ScanMatch match;
  const PclCloud::Ptr thin_target = thinned(target, params.voxel);
  const PclCloud::Ptr thin_source = thinned(source, params.voxel);
  if (thin_target->size() < min_points || thin_source->size() < min_points) return match;
  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
  ndt.setResolution(static_cast<float>(params.resolution));
  ndt.setTransformationEpsilon(1e-4);
  ndt.setStepSize(0.1);
  ndt.setMaximumIterations(40);
  ndt.setInputTarget(thin_target);
  ndt.setInputSource(thin_source);
  Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  guess.topLeftCorner<3, 3>() = guess_T_target_source.matrix().cast<float>();
  guess.topRightCorner<3, 1>() = guess_T_target_source.translation.cast<float>();
  PclCloud aligned;
  ndt.align(aligned, guess);
  const Eigen::Matrix4d result = ndt.getFinalTransformation().cast<double>();
  if (!ndt.hasConverged() || !result.allFinite()) {
    match.failure = MatchFailure::not_converged;
    return match;
  }
  match.T_target_source = {Eigen::Quaterniond(Eigen::Matrix3d(result.topLeftCorner<3, 3>())).normalized(), result.topRightCorner<3, 1>()};
  Surfaces surfaces(thin_target);
  polish(surfaces, *thin_source, &match.T_target_source);
  judge(surfaces, *thin_source, params, &match);
  match.failure = match.overlap < params.min_overlap   ? MatchFailure::overlap
                  : match.fitness > params.max_fitness ? MatchFailure::fitness
                                                       : MatchFailure::none;
  return match;
}

}  // namespace sgraph
