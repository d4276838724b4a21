#include "sgraph_slam/core/odometry/window_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double height_sigma = 0.01;         // [m] that the height changes by in such a step: robots and people stay on their floor
constexpr double measurement_kernel2 = 36.0;  // squared standard deviations at which another sensor's say has fallen to a quarter

// Sums over the points of one segment. Every Jacobian is (1 - a) u for the knot before and a u for the knot after, so three weighted sums of u u^T
// are all.
struct SegmentSums {
  std::array<Matrix6, 3> uu{Matrix6::Zero(), Matrix6::Zero(), Matrix6::Zero()};
  std::array<Vector6, 2> ur{Vector6::Zero(), Vector6::Zero()};
};

// The same before it is weighed: sums of u u^T, lower half, over slices of the segment within which `a` is nearly the same. A Gauss-Newton matrix
// needs no more.
constexpr int slices = 8;
using SlicedSums = std::array<Matrix6, slices>;

void add_outer_product(const Vector6& u, double weight, Matrix6& sum) {
  for (int j = 0; j < 6; ++j) {
    const double wu = weight * u[j];
    for (int i = j; i < 6; ++i) sum(i, j) += wu * u[i];
  }
}

void weigh(const SlicedSums& sliced, SegmentSums& sums) {
  for (int k = 0; k < slices; ++k) {
    const double after = (k + 0.5) / slices;
    const double before = 1.0 - after;
    const Matrix6& half = sliced[static_cast<std::size_t>(k)];
    const Matrix6 uu = half.selfadjointView<Eigen::Lower>();
    sums.uu[0] += before * before * uu;
    sums.uu[1] += before * after * uu;
    sums.uu[2] += after * after * uu;
  }
}

struct Linearisation {
  double cost = 0;
  int inliers = 0;     // of the newest scan
  int newest = 0;      // its keypoints,
  int matched = 0;     // and those of them that are near a surface
  double squares = 0;  // of the inliers
  MatrixXd h;
  MatrixXd points;  // the part of h that comes from points
  VectorXd b;
};

// Half the noise across a plane and `flatness` times its variance along it: the plane regularisation of VGICP.
Eigen::Matrix3d flattened(const Vector3d& normal, double noise) {
  constexpr double flatness = 1e3;
  const double across = 0.5 * noise * noise;
  const Eigen::Matrix3d nn = normal * normal.transpose();
  return across * nn + flatness * across * (Eigen::Matrix3d::Identity() - nn);
}

// Inverse square root of the covariance sigma^2 I + d d^T.
Eigen::Matrix3d whitening(double sigma, const Vector3d& d) {
  const double squared = d.squaredNorm();
  if (squared < 1e-24) return Eigen::Matrix3d::Identity() / sigma;
  const double less = 1.0 - sigma / std::sqrt(sigma * sigma + squared);
  return (Eigen::Matrix3d::Identity() - (less / squared) * d * d.transpose()) / sigma;
}

class Problem {
 public:
  Problem(const SurfaceMap& map, const WindowProblem& problem, const WindowOptions& options)
      : map_(map), problem_(problem), options_(options), matches_(problem.keypoints.size()) {}

  /// The kernel must not grow from call to call.
  [[nodiscard]] Linearisation linearise(const Knots& knots, double kernel) {
    Linearisation l;
    const auto size = 6 * (static_cast<Eigen::Index>(knots.size()) - problem_.first_free);
    l.h = MatrixXd::Zero(size, size);
    l.b = VectorXd::Zero(size);
    add_points(knots, kernel, l);
    l.points = l.h;
    add_prior(knots, l);
    add_height(knots, l);
    add_measurements(knots, l);
    return l;
  }

 private:
  // A point's squared residual [m^2], half its derivative by a turn about the sensor and a shift, and J^T J.
  struct PointTerm {
    double squared;
    Vector6 b;
    Matrix6 h;
  };

  // Mahalanobis distance of the point from the surface's mean, in units of the noise: with two parallel planes nearly what lies along the normal.
  [[nodiscard]] PointTerm between_distributions(const Surface& surface, const Vector3d& p, const Vector3d& arm, const Vector3d& normal) const {
    const double noise2 = options_.noise * options_.noise;
    const Eigen::Matrix3d own =
        normal.squaredNorm() > 0 ? flattened(normal, options_.noise) : Eigen::Matrix3d(0.5 * noise2 * Eigen::Matrix3d::Identity());
    const Eigen::Matrix3d weight = noise2 * (flattened(surface.normal, options_.noise) + own).inverse();
    Eigen::Matrix<double, 3, 6> jacobian;
    jacobian << -skew(arm), Eigen::Matrix3d::Identity();
    const Vector3d off = p - surface.mean;
    const Eigen::Matrix<double, 6, 3> weighted = jacobian.transpose() * weight;
    return {off.dot(weight * off), weighted * off, weighted * jacobian};
  }

  void add_points(const Knots& knots, double kernel, Linearisation& l) {
    const std::vector<SegmentMotion> motions = segment_motions(knots);
    std::vector<SegmentSums> sums(motions.size());
    std::vector<SlicedSums> sliced(motions.size());
    for (SlicedSums& s : sliced) s.fill(Matrix6::Zero());
    const double k2 = kernel * kernel;
    const double information = 1.0 / (options_.noise * options_.noise);
    const double gate = options_.gate_scale * kernel;
    for (std::size_t i = 0; i < problem_.keypoints.size(); ++i) {
      const Keypoint& point = problem_.keypoints[i];
      const SegmentMotion& motion = motions[static_cast<std::size_t>(point.segment)];
      const Vector3d arm = motion.rotate(point.fraction, point.p_lidar);
      const Vector3d sensor = motion.origin(point.fraction);
      const Vector3d p = arm + sensor;
      l.newest += point.newest;
      const Surface* surface = matches_[i].find(map_, p, sensor, gate);
      std::optional<Surface> stood;
      if (options_.plumb && surface != nullptr) {
        stood = plumb(*surface, problem_.up);
        if (stood || !options_.oblique) surface = stood ? &*stood : nullptr;
      }
      if (surface == nullptr) {
        l.cost += k2 * information;  // where Geman-McClure levels off: losing a match never pays
        continue;
      }
      l.matched += point.newest;
      SegmentSums& s = sums[static_cast<std::size_t>(point.segment)];
      SlicedSums& slice = sliced[static_cast<std::size_t>(point.segment)];
      const auto k = static_cast<std::size_t>(std::clamp(static_cast<int>(slices * point.fraction), 0, slices - 1));
      double r2 = 0;
      double w = 0;
      Vector6 b;
      if (options_.distributions) {
        const PointTerm term = between_distributions(*surface, p, arm, motion.rotate(point.fraction, point.normal));
        r2 = term.squared;
        w = weight(k2, r2, information);
        b = w * term.b;
        slice[k] += w * term.h;
      } else {
        const double r = surface->distance(p);
        r2 = r * r;
        w = weight(k2, r2, information);
        Vector6 u;
        u << arm.cross(surface->normal), surface->normal;
        b = (w * r) * u;
        add_outer_product(u, w, slice[k]);
      }
      l.cost += k2 / (k2 + r2) * r2 * information;
      if (point.newest && r2 < k2) {
        ++l.inliers;
        l.squares += r2;
      }
      s.ur[0] += (1.0 - point.fraction) * b;
      s.ur[1] += point.fraction * b;
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      weigh(sliced[i], sums[i]);
      if (i < problem_.observable.size()) project(problem_.observable[i], sums[i]);
      add_segment(static_cast<int>(i), sums[i], l);
    }
  }

  // Geman-McClure.
  static double weight(double k2, double r2, double information) {
    const double share = k2 / (k2 + r2);
    return share * share * information;
  }

  static void project(const Matrix6& held, SegmentSums& s) {
    for (Matrix6& uu : s.uu) uu = (held.transpose() * uu * held).eval();
    for (Vector6& ur : s.ur) ur = (held.transpose() * ur).eval();
  }

  void add_segment(int segment, const SegmentSums& s, Linearisation& l) const {
    const Eigen::Index a = 6 * (segment - problem_.first_free);
    const Eigen::Index c = a + 6;
    if (c < 0) return;
    l.h.block<6, 6>(c, c) += s.uu[2];
    l.b.segment<6>(c) += s.ur[1];
    if (a < 0) return;
    l.h.block<6, 6>(a, a) += s.uu[0];
    l.h.block<6, 6>(a, c) += s.uu[1];
    l.h.block<6, 6>(c, a) += s.uu[1];
    l.b.segment<6>(a) += s.ur[0];
  }

  // Change of velocity at each inner knot, times the step, in the sensor's own axes: what walks, drives or climbs goes where it points. In odom's
  // axes a body that tips level at the top of a flight of stairs would have to slow down upwards as it turns.
  void add_prior(const Knots& knots, Linearisation& l) const {
    const int first = std::max(1, problem_.first_free - 1);
    if (first + 1 >= static_cast<int>(knots.size())) return;
    SegmentVelocity after = velocity(knots[static_cast<std::size_t>(first) - 1], knots[static_cast<std::size_t>(first)]);
    for (int j = first; j + 1 < static_cast<int>(knots.size()); ++j) {
      const auto i = static_cast<std::size_t>(j);
      const Knot& here = knots[i];
      const SegmentVelocity before = after;
      after = velocity(here, knots[i + 1]);
      const double step = 0.5 * (before.time + after.time);
      const double growth = std::pow(step / VelocityPrior::step, 1.5);  // white noise on the acceleration
      const double c1 = step / before.time;
      const double c2 = step / after.time;
      Eigen::Matrix<double, 6, 18> jacobian;
      jacobian << -c1 * before.by_begin, c2 * after.by_begin - c1 * before.by_end, c2 * after.by_end;
      Vector6 e = c2 * after.motion - c1 * before.motion;
      const VelocityPrior& prior = problem_.prior[i];
      const Eigen::Matrix3d to_here = here.pose.matrix().transpose();
      const Eigen::Matrix3d wr = whitening(prior.rotation_sigma, to_here * prior.rotated) / growth;
      const Eigen::Matrix3d wt = whitening(prior.translation_sigma, to_here * prior.translated) / growth;
      jacobian.topRows<3>() = (wr * jacobian.topRows<3>()).eval();
      jacobian.bottomRows<3>() = (wt * jacobian.bottomRows<3>()).eval();
      e << wr * Vector3d(e.head<3>()), wt * Vector3d(e.tail<3>());
      l.cost += e.squaredNorm();
      add_residual<3>(j - 1, jacobian, jacobian, e, l);
    }
  }

  // Turn and way of a segment in the sensor's axes at its middle, and their derivatives by the knots.
  struct SegmentVelocity {
    double time;
    Vector6 motion;
    Matrix6 by_begin, by_end;
  };
  static SegmentVelocity velocity(const Knot& begin, const Knot& end) {
    SegmentVelocity v;
    v.time = end.time - begin.time;
    const Vector3d turn = so3_log(begin.pose.rotation.conjugate() * end.pose.rotation);
    const Vector3d way = end.pose.translation - begin.pose.translation;
    const Eigen::Matrix3d to_begin = begin.pose.matrix().transpose();
    const Eigen::Matrix3d to_middle = so3_exp(-0.5 * turn).toRotationMatrix() * to_begin;
    v.motion << turn, to_middle * way;
    const Eigen::Matrix3d turned = 0.5 * to_middle * skew(way);
    const Eigen::Matrix3d none = Eigen::Matrix3d::Zero();
    v.by_begin << -to_begin, none, turned, -to_middle;
    v.by_end << to_begin, none, turned, to_middle;
    return v;
  }

  void add_height(const Knots& knots, Linearisation& l) const {
    for (int i = problem_.first_free - 1; i + 1 < static_cast<int>(knots.size()); ++i) {
      const Knot& begin = knots[static_cast<std::size_t>(i)];
      const Knot& end = knots[static_cast<std::size_t>(i) + 1];
      const double weight = VelocityPrior::step / (height_sigma * height_sigma * (end.time - begin.time));
      const double climb = problem_.up.dot(end.pose.translation - begin.pose.translation);
      l.cost += weight * climb * climb;
      const Eigen::Matrix3d h = weight * problem_.up * problem_.up.transpose();
      const Eigen::Index a = 6 * (i - problem_.first_free) + 3;
      const Eigen::Index c = a + 6;
      l.h.block<3, 3>(c, c) += h;
      l.b.segment<3>(c) += weight * climb * problem_.up;
      if (a < 0) continue;
      l.h.block<3, 3>(a, a) += h;
      l.h.block<3, 3>(a, c) -= h;
      l.h.block<3, 3>(c, a) -= h;
      l.b.segment<3>(a) -= weight * climb * problem_.up;
    }
  }

  // Motion along a segment in the axes of its begin, less the measured one. Geman-McClure: a sensor that is far off has no say.
  void add_measurements(const Knots& knots, Linearisation& l) const {
    for (const SegmentMeasurement& m : problem_.measurements) {
      const Pose& begin = knots[static_cast<std::size_t>(m.segment)].pose;
      const Pose& end = knots[static_cast<std::size_t>(m.segment) + 1].pose;
      const Pose& motion = m.measured.motion;
      const Eigen::Matrix3d to_begin = begin.matrix().transpose();
      const Eigen::Matrix3d to_end = end.matrix().transpose();
      const Vector3d way = end.translation - begin.translation;
      Vector6 e;
      e << so3_log(motion.rotation.conjugate() * begin.rotation.conjugate() * end.rotation), to_begin * way - motion.translation;
      Eigen::Matrix<double, 6, 12> jacobian = Eigen::Matrix<double, 6, 12>::Zero();
      const Eigen::Matrix3d turn = so3_right_jacobian_inverse(e.head<3>()) * to_end;
      jacobian.block<3, 3>(0, 0) = -turn;
      jacobian.block<3, 3>(0, 6) = turn;
      jacobian.block<3, 3>(3, 0) = to_begin * skew(way);
      jacobian.block<3, 3>(3, 3) = -to_begin;
      jacobian.block<3, 3>(3, 9) = to_begin;
      const double squared = e.dot(m.measured.information * e);
      const double share = measurement_kernel2 / (measurement_kernel2 + squared);
      l.cost += share * squared;
      add_residual<2>(m.segment, jacobian, share * share * m.measured.information * jacobian, e, l);
    }
  }

  // A residual of N knots in a row, the first of them `first`. `weighted`: its information times the Jacobian.
  template <int N>
  void add_residual(int first, const Eigen::Matrix<double, 6, 6 * N>& jacobian, const Eigen::Matrix<double, 6, 6 * N>& weighted, const Vector6& e,
                    Linearisation& l) const {
    for (int a = 0; a < N; ++a) {
      const Eigen::Index row = 6 * (first + a - problem_.first_free);
      if (row < 0) continue;
      const auto ja = weighted.template block<6, 6>(0, 6 * a);
      l.b.segment<6>(row) += ja.transpose() * e;
      for (int c = 0; c < N; ++c) {
        const Eigen::Index column = 6 * (first + c - problem_.first_free);
        if (column >= 0) l.h.block<6, 6>(row, column) += ja.transpose() * jacobian.template block<6, 6>(0, 6 * c);
      }
    }
  }

  const SurfaceMap& map_;
  const WindowProblem& problem_;
  const WindowOptions& options_;
  std::vector<CachedMatch> matches_;  // a keypoint
};

Knots moved(const Knots& knots, int first_free, const VectorXd& step) {
  Knots result = knots;
  for (std::size_t i = static_cast<std::size_t>(first_free); i < knots.size(); ++i) {
    const auto k = 6 * (static_cast<Eigen::Index>(i) - first_free);
    result[i].pose.rotation = (so3_exp(step.segment<3>(k)) * knots[i].pose.rotation).normalized();
    result[i].pose.translation += step.segment<3>(k + 3);
  }
  return result;
}

// Largest movement of a step: metres, with rotations counted at 5 m.
double size_of(const VectorXd& step) {
  double largest = 0;
  for (Eigen::Index k = 0; k < step.size(); k += 6) largest = std::max({largest, 5.0 * step.segment<3>(k).norm(), step.segment<3>(k + 3).norm()});
  return largest;
}

}  // namespace

WindowResult solve_window(const SurfaceMap& map, WindowProblem& problem, const WindowOptions& options) {
  constexpr double small_step = 2e-4;
  constexpr double least_rms = 0.003;  // [m]: a good sensor's; without noise a fit says nothing of how good it is
  Problem linear(map, problem, options);
  WindowResult result;
  double scale = options.start_scale;
  double damping = 0;
  Linearisation at = linear.linearise(problem.knots, scale * options.kernel);
  for (result.iterations = 0; result.iterations < options.iterations;) {
    ++result.iterations;
    MatrixXd h = at.h;
    h.diagonal() *= 1.0 + damping;
    const VectorXd step = -h.ldlt().solve(at.b);
    if (!step.allFinite()) break;
    const Knots next = moved(problem.knots, problem.first_free, step);
    const double next_scale = std::max(1.0, 0.5 * scale);
    Linearisation there = linear.linearise(next, next_scale * options.kernel);
    if (next_scale == scale && there.cost > at.cost * (1 + 1e-6)) {
      damping = damping == 0 ? 0.1 : 10 * damping;
      if (damping > 1e4) break;
      continue;
    }
    damping *= 0.1;
    if (damping < 1e-3) damping = 0;
    problem.knots = next;
    at = std::move(there);
    const bool settled = next_scale == scale;
    scale = next_scale;
    if (settled && size_of(step) < small_step) {
      result.converged = true;
      break;
    }
  }
  result.inlier_share = at.newest > 0 ? static_cast<double>(at.inliers) / at.newest : 0;
  result.agreement = at.matched > 0 ? static_cast<double>(at.inliers) / at.matched : 0;
  result.residual_rms = at.inliers > 0 ? std::sqrt(at.squares / at.inliers) : 0;
  // What the points say is as good as they fit, and no better than the patches of the map's surfaces that they lie on.
  const double variance = std::max(least_rms * least_rms, result.residual_rms * result.residual_rms) * options.patch_effect;
  result.information = at.h + (options.noise * options.noise / variance - 1) * at.points;
  return result;
}

}  // namespace sgraph
