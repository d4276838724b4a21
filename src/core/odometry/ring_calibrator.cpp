#include "sgraph_slam/core/odometry/ring_calibrator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/sensor/ring_table.hpp"

namespace sgraph {
namespace {

constexpr double degree = M_PI / 180;
// Two measured VLP-16 have range offsets of 6 and 10 mm rms, and elevations off by up to 0.07 degrees (docs/sensors.md).
constexpr double range_prior = 0.01;               // [m]
constexpr double elevation_prior = 0.05 * degree;  // [rad]
constexpr double mean_sigma = 1e-4;                // [m] of the mean of the range offsets, which is zero by definition
// A calibration is good for one mounting and temperature; from month to month offsets wander by a few millimetres (Chio 2022).
constexpr double kept_range_sigma = 0.003;              // [m]
constexpr double kept_elevation_sigma = 0.02 * degree;  // [rad]

constexpr double free_elevation = 1 * degree;  // when it is asked what the data alone says of the vertical offsets
constexpr double vertical_told = 0.2;          // standard deviation of their share: five of them lie between lacking and present

constexpr double fixed_weight = 1e12;  // of a parameter that is settled

constexpr double edge = 1.0;                // [m] of a voxel
constexpr int voxel_points = 40;            // that a voxel is fitted with; again at every doubling
constexpr int most_voxel_points = 640;      // after which one that isn't flat is given up
constexpr double flat_sigma = 0.03;         // [m] three halves of the noise of the noisiest sensors
constexpr double wide_sigma = 0.12;         // [m] a stripe doesn't tell how a surface leans
constexpr double plane_angle = 3 * degree;  // between voxels of one plane
constexpr double plane_offset = 0.05;       // [m]
constexpr double plane_radius = 6.0;        // [m] floors slope and undulate by millimetres over more
constexpr double least_gate = 0.015;        // [m] three times the noise of a quiet sensor
constexpr double most_gate = 0.06;          // [m] ... and of the noisiest
// Share of a voxel's points beyond the gate. Where there are more, another surface begins within the voxel, and its points within the gate all pull
// to one side.
constexpr double most_outside = 0.02;

// A point counts as if it had this noise: eight points with the 7 mm of a real sensor, which share texture, intensity and incidence.
constexpr double point_sigma = 0.02;  // [m]
// By how much a scan may be off a plane as a whole.
constexpr double pose_sigma = 0.008;    // [m]
constexpr double pose_tilt = 0.002;     // [rad]
constexpr double edge_distance = 0.15;  // [m] from a plane that crosses: more than twice the widest gate
constexpr double parallel = 0.9;        // cosine between planes that don't cross
constexpr double least_cosine = 0.04;   // grazing rays tell of the surface's texture
constexpr double farthest = 25.0;       // [m]

constexpr double place_distance = 0.2;  // [m] between scans that are taken
constexpr double place_angle = 0.15;    // [rad]
constexpr int scans_a_place = 5;        // standing still shows the same textures again and again
constexpr int scans_a_solution = 20;
constexpr int least_scans = 40;  // before anything is taken out
constexpr int most_scans = 100;  // after which beams that aren't known yet stay as they are
constexpr int shown_scans = 20;  // in which the beams must show

// A sensor without errors comes out with offsets of 0.7 to 1.4 mm (rms), whatever their standard deviations say: texture, edges, and what elevations
// take for themselves. Offsets are taken out when they are so large that this can't be more than a quarter of their variance.
constexpr double own_error = 0.0015;  // [m]

// The errors of an odometry's poses lift all beams alike by this much in three simulated units (docs/sensors.md).
constexpr double own_elevation_error = 0.025 * degree;  // [rad]

std::array<int, 3> cell_of(const Eigen::Vector3d& p) {
  const Eigen::Vector3d at = (p / plane_radius).array().floor();
  return {static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z())};
}

}  // namespace

RingCalibrator::RingCalibrator(const CalibrationParams& params) : params_(params), index_(edge) {
  if (!params.file.empty() && params.mode != "off") calibration_ = std::make_shared<const RingCalibration>(read_calibration(params.file));
  taken_out_ = calibration_;
  decided_ = params.mode != "auto" || taken_out_->corrects();
}

void RingCalibrator::switch_off() {
  rings_ = 0;
  decided_ = true;
  next_.reset();
  shown_ = shown_scans;
  taken_out_ = calibration_ = std::make_shared<const RingCalibration>();
}

void RingCalibrator::recognise(const Cloud& raw) {
  added_.reset();
  if (next_) begin_to_take_out();
  if (params_.mode == "fixed" || params_.mode == "off" || shown_ >= shown_scans) return;
  ++shown_;
  learn_beams(raw);
  if (shown_ >= shown_scans && rings_ == 0) decided_ = true;
}

void RingCalibrator::learn_beams(const Cloud& raw) {
  const auto table = table_by_ring(raw);
  if (!table) return;
  if (!table->sharp) {  // somebody has moved the points since the sensor saw them
    switch_off();
    return;
  }
  const auto rings = static_cast<int>(table->row_of_ring.size());
  if (rings_ > 0 || rings < 4 || rings > 256) return;
  rings_ = rings;
  counts_.assign(table->row_of_ring.size(), false);
  const bool lacks_offsets = table->from_one_point && model_of(*table) == "VLP-16";
  auto calibration = std::make_shared<RingCalibration>(*calibration_);
  const bool known = calibration->beams.size() == static_cast<std::size_t>(rings);
  if (!known) *calibration = {};
  calibration->beams.resize(static_cast<std::size_t>(rings));
  calibration->vertical_offsets.clear();
  if (lacks_offsets) {
    for (const int row : table->row_of_ring)
      calibration->vertical_offsets.push_back(row < 0 ? 0.0 : vlp16_vertical_offsets()[static_cast<std::size_t>(row)]);
  }
  if (!lacks_offsets) calibration->vertical_applied = false;
  vertical_settled_ = !lacks_offsets || (known && calibration->vertical_settled);
  if (lacks_offsets && params_.vertical != "auto") {
    vertical_settled_ = true;
    calibration->vertical_applied = params_.vertical == "lacking";
  }
  calibration->vertical_settled = lacks_offsets && vertical_settled_;
  h_ = Eigen::MatrixXd::Zero(unknowns(), unknowns());
  b_ = Eigen::VectorXd::Zero(unknowns());
  applied_ = Eigen::VectorXd::Zero(unknowns());
  prior_mean_ = Eigen::VectorXd::Zero(unknowns());
  prior_weight_ = Eigen::VectorXd::Zero(unknowns());
  for (int ring = 0; ring < rings; ++ring) {
    BeamCalibration& beam = calibration->beams[static_cast<std::size_t>(ring)];
    if (!vertical_settled_) {  // they may stand for the vertical offsets
      beam.elevation_offset = beam.elevation_sigma = 0;
      beam.elevation_applied = false;
    }
    prior_mean_[ring] = beam.range_offset;
    prior_mean_[rings + ring] = beam.elevation_offset;
    const double range = known ? std::hypot(std::min(beam.range_sigma, range_prior), kept_range_sigma) : range_prior;
    const double elevation =
        known && vertical_settled_ ? std::hypot(std::min(beam.elevation_sigma, elevation_prior), kept_elevation_sigma) : elevation_prior;
    prior_weight_[ring] = 1 / (range * range);
    prior_weight_[rings + ring] = 1 / (elevation * elevation);
    if (beam.range_applied) applied_[ring] = beam.range_offset;
    if (beam.elevation_applied) applied_[rings + ring] = beam.elevation_offset;
  }
  vertical_share_ = calibration->vertical_share;
  vertical_sigma_ = calibration->vertical_sigma;
  const double share = calibration->vertical_applied ? 1.0 : 0.0;
  applied_[2 * rings] = share;
  prior_mean_[2 * rings] = vertical_settled_ ? share : 0.5;
  prior_weight_[2 * rings] = vertical_settled_ ? fixed_weight : 4.0;
  taken_out_ = calibration_ = calibration;
}

bool RingCalibrator::same_place(const Pose& pose) {
  const bool moved =
      !last_ || (pose.translation - last_->translation).norm() > place_distance || rotation_angle(last_->rotation, pose.rotation) > place_angle;
  if (moved) {
    last_ = pose;
    at_place_ = 0;
  }
  return ++at_place_ > scans_a_place;
}

void RingCalibrator::add(const Cloud& scan, const Pose& T_odom_lidar) {
  if (rings_ == 0) return;
  if (same_place(T_odom_lidar)) return;
  ++scans_;
  measure(scan, T_odom_lidar);
  const Eigen::Matrix3d rotation = T_odom_lidar.matrix();
  for (const Point& p : scan.points) insert(rotation * p.position().cast<double>() + T_odom_lidar.translation, T_odom_lidar.translation);
  if (++since_solved_ < scans_a_solution) return;
  since_solved_ = 0;
  solve();
  if (scans_ >= most_scans) decided_ = true;
}

void RingCalibrator::insert(const Vector3& p, const Vector3& sensor) {
  const std::uint32_t at = index_.find_or_add(index_.key(p));
  if (at == voxels_.size()) {
    voxels_.emplace_back();
    voxels_.back().centre = p;
  }
  Voxel& voxel = voxels_[at];
  if (voxel.plane >= 0 || voxel.count >= most_voxel_points) return;
  const Vector3 q = p - voxel.centre;
  ++voxel.count;
  voxel.sum += q;
  voxel.outer += q * q.transpose();
  const int doubled = voxel.count / voxel_points;
  if (voxel.count % voxel_points == 0 && (doubled & (doubled - 1)) == 0) flatten(voxel, sensor);
}

void RingCalibrator::flatten(Voxel& voxel, const Vector3& sensor) {
  const Vector3 mean = voxel.sum / voxel.count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(voxel.outer / voxel.count - mean * mean.transpose());
  const Vector3& variances = solver.eigenvalues();
  if (variances[0] > flat_sigma * flat_sigma || variances[1] < wide_sigma * wide_sigma) return;
  voxel.mean = voxel.centre + mean;
  voxel.normal = solver.eigenvectors().col(0);
  if (voxel.normal.dot(sensor - voxel.mean) < 0) voxel.normal = -voxel.normal;
  voxel.gate = std::clamp(3 * std::sqrt(std::max(0.0, variances[0])), least_gate, most_gate);
  voxel.plane = plane_for(voxel.mean, voxel.normal);
}

// Visits the planes whose centres lie in the cells around a point.
template <class Visit>
void RingCalibrator::visit_planes(const Vector3& p, int cells, Visit visit) const {
  const std::array<int, 3> middle = cell_of(p);
  for (int x = middle[0] - cells; x <= middle[0] + cells; ++x) {
    for (int y = middle[1] - cells; y <= middle[1] + cells; ++y) {
      for (int z = middle[2] - cells; z <= middle[2] + cells; ++z) {
        const auto at = planes_at_.find({x, y, z});
        if (at != planes_at_.end()) std::for_each(at->second.begin(), at->second.end(), visit);
      }
    }
  }
}

int RingCalibrator::plane_for(const Vector3& mean, const Vector3& normal) {
  int best = -1;
  double nearest = plane_radius;
  visit_planes(mean, 1, [&](int i) {
    const Plane& plane = planes_[static_cast<std::size_t>(i)];
    const Vector3 away = mean - plane.centre;
    const double distance = away.norm();
    if (distance >= nearest || plane.normal.dot(normal) < std::cos(plane_angle) || std::abs(plane.normal.dot(away)) > plane_offset) return;
    best = i;
    nearest = distance;
  });
  if (best >= 0) return best;
  const int added = static_cast<int>(planes_.size());
  Plane plane;
  plane.centre = mean;
  plane.normal = normal;
  plane.first = normal.unitOrthogonal();
  plane.second = normal.cross(plane.first);
  plane.cross = Eigen::MatrixXd::Zero(unknowns(), 3);
  visit_planes(mean, 3, [&](int i) {  // its points and those of the others reach a plane's radius and a voxel
    Plane& other = planes_[static_cast<std::size_t>(i)];
    if (std::abs(other.normal.dot(normal)) >= parallel || (other.centre - mean).norm() > 2 * (plane_radius + 2 * edge)) return;
    other.crossed.push_back(added);
    plane.crossed.push_back(i);
  });
  planes_.push_back(std::move(plane));
  planes_at_[cell_of(mean)].push_back(added);
  return added;
}

void RingCalibrator::measure(const Cloud& scan, const Pose& T_odom_lidar) {
  constexpr double weight = 1 / (point_sigma * point_sigma);
  const Eigen::Matrix3d rotation = T_odom_lidar.matrix();
  const Vector3 axis = rotation.col(2);  // the sensor's, upward
  const auto& offsets = calibration_->vertical_offsets;
  std::map<int, ScanSums> by_plane;
  for (const Point& point : scan.points) {
    if (point.ring >= rings_) continue;
    const Vector3 ray = rotation * point.position().cast<double>();
    const Vector3 p = ray + T_odom_lidar.translation;
    const std::uint32_t at = index_.find(index_.key(p));
    if (at == VoxelIndex::none || voxels_[at].plane < 0) continue;
    Voxel& voxel = voxels_[at];
    const Vector3 direction = ray.normalized();
    const double cosine = -voxel.normal.dot(direction);
    const bool within = std::abs(voxel.normal.dot(p - voxel.mean)) < voxel.gate;
    ++(within ? voxel.inside : voxel.outside);
    if (!within || voxel.outside > most_outside * voxel.inside + 2) continue;
    if (cosine < least_cosine) continue;
    // Where the ray meets the surface, without the noise of its range: with it, the coefficients would go with the residual, and what the data hardly
    // holds would be pulled far off.
    const double range = voxel.normal.dot(T_odom_lidar.translation - voxel.mean) / cosine;
    const Vector3 met = T_odom_lidar.translation + range * direction;
    if (range > farthest || near_edge(met, voxel.plane)) continue;
    const Plane& plane = planes_[static_cast<std::size_t>(voxel.plane)];
    const Vector3 upward = (axis - axis.dot(direction) * direction).normalized();
    const auto ring = static_cast<std::size_t>(point.ring);
    const double raised = ring < offsets.size() ? offsets[ring] : 0.0;
    const Vector3 j(plane.normal.dot(direction), -range * plane.normal.dot(upward), -raised * plane.normal.dot(axis));
    const Vector3 from_centre = met - plane.centre;
    const Vector3 s(1, plane.first.dot(from_centre), plane.second.dot(from_centre));
    const Vector3 applied(applied_[point.ring], applied_[rings_ + point.ring], applied_[2 * rings_]);
    const double y = plane.normal.dot(p - plane.centre) + j.dot(applied);
    ScanSums& sums = by_plane[voxel.plane];
    if (sums.rings.empty()) sums.rings.resize(static_cast<std::size_t>(rings_));
    RingSums& own = sums.rings[ring];
    own.jj += weight * j * j.transpose();
    own.js += weight * j * s.transpose();
    own.jy += weight * y * j;
    ++own.count;
    sums.ss += weight * s * s.transpose();
    sums.sy += weight * y * s;
    ++sums.count;
    counts_[ring] = true;
  }
  for (const auto& [plane, sums] : by_plane) take_sums(plane, sums);
}

// Beside another plane that crosses this one, points of the other within the gate pull all to one side.
bool RingCalibrator::near_edge(const Vector3& p, int own) const {
  const std::vector<int>& crossed = planes_[static_cast<std::size_t>(own)].crossed;
  return std::any_of(crossed.begin(), crossed.end(), [&](int i) {
    const Plane& other = planes_[static_cast<std::size_t>(i)];
    const Vector3 away = p - other.centre;
    return std::abs(other.normal.dot(away)) < edge_distance && away.norm() < plane_radius + edge;
  });
}

void RingCalibrator::take_sums(int plane, const ScanSums& sums) {
  // How this scan as a whole is off the plane, a small unknown of its own, is eliminated here.
  Eigen::Matrix3d own = sums.ss;
  own.diagonal() += Vector3(1 / (pose_sigma * pose_sigma), 1 / (pose_tilt * pose_tilt), 1 / (pose_tilt * pose_tilt));
  const Eigen::Matrix3d k = own.inverse();
  Eigen::MatrixXd js = Eigen::MatrixXd::Zero(unknowns(), 3);
  for (int ring = 0; ring < rings_; ++ring) {
    const RingSums& r = sums.rings[static_cast<std::size_t>(ring)];
    if (r.count == 0) continue;
    const std::array<Eigen::Index, 3> at{ring, rings_ + ring, 2 * rings_};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      js.row(at[i]) += r.js.row(row);
      b_[at[i]] += r.jy[row];
      for (std::size_t j = 0; j < 3; ++j) h_(at[i], at[j]) += r.jj(row, static_cast<Eigen::Index>(j));
    }
  }
  h_.noalias() -= js * k * js.transpose();
  b_ -= js * (k * sums.sy);
  Plane& p = planes_[static_cast<std::size_t>(plane)];
  p.h += sums.ss - sums.ss * k * sums.ss;
  p.b += sums.sy - sums.ss * (k * sums.sy);
  p.cross += js - js * k * sums.ss;
}

void RingCalibrator::solve() {
  Eigen::MatrixXd h = h_;
  Eigen::VectorXd b = b_;
  for (const Plane& plane : planes_) {
    const Eigen::Matrix3d inverse = (plane.h + Eigen::Matrix3d::Identity()).inverse();  // a metre, a radian: nothing is known of it beforehand
    h.noalias() -= plane.cross * inverse * plane.cross.transpose();
    b -= plane.cross * (inverse * plane.b);
  }
  h.diagonal() += prior_weight_;
  b += prior_weight_.cwiseProduct(prior_mean_);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(unknowns());
  const auto seen = static_cast<double>(std::count(counts_.begin(), counts_.end(), true));
  for (int ring = 0; ring < rings_; ++ring) mean[ring] = counts_[static_cast<std::size_t>(ring)] ? 1 / std::max(seen, 1.0) : 0.0;
  h += mean * mean.transpose() / (mean_sigma * mean_sigma);
  if (!vertical_settled_) {
    // One beam meets floors, and ceilings, at one distance nearly everywhere, and there its elevation does what its vertical offset would. What tells
    // the two apart must be the data and not what was expected of the elevations: small errors of the poses, which all scans share, outweigh that.
    Eigen::MatrixXd free = h;
    Eigen::VectorXd free_b = b;
    for (Eigen::Index i = rings_; i < 2 * rings_; ++i) {
      free(i, i) += 1 / (free_elevation * free_elevation) - prior_weight_[i];
      free_b[i] -= prior_weight_[i] * prior_mean_[i];
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(free);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return;
    vertical_share_ = factor.solve(free_b)[2 * rings_];
    vertical_sigma_ = std::sqrt(std::max(0.0, factor.solve(Eigen::VectorXd::Unit(unknowns(), 2 * rings_))[2 * rings_]));
    settle_vertical(vertical_share_, vertical_sigma_);
    // The other parameters are those that go with what is taken for true, not with a mixture of the two.
    h(2 * rings_, 2 * rings_) += fixed_weight;
    b[2 * rings_] += fixed_weight * (vertical_settled_ ? prior_mean_[2 * rings_] : 0.0);
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(h);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return;
  const Eigen::VectorXd x = factor.solve(b);
  const Eigen::VectorXd sigma = factor.solve(Eigen::MatrixXd::Identity(unknowns(), unknowns())).diagonal().cwiseMax(0).cwiseSqrt();
  if (!x.allFinite() || !sigma.allFinite()) return;

  const bool errs = std::sqrt(x.head(rings_).squaredNorm() / std::max(seen, 1.0)) > 2 * own_error;
  if (errs && scans_ >= least_scans && !vertical_settled_) {
    settle_vertical_as(1);
    solve();  // ranges that go with it
    return;
  }
  auto calibration = std::make_shared<RingCalibration>(*calibration_);
  calibration->scans = scans_;
  calibration_ = calibration;
  for (int ring = 0; ring < rings_; ++ring) {
    BeamCalibration& beam = calibration->beams[static_cast<std::size_t>(ring)];
    beam.range_offset = x[ring];
    beam.range_sigma = sigma[ring];
    beam.elevation_offset = x[rings_ + ring];
    beam.elevation_sigma = std::hypot(sigma[rings_ + ring], own_elevation_error);
    if (scans_ < least_scans) continue;
    beam.range_applied = beam.range_applied || (errs && sigma[ring] < params_.range_sigma);
    // Until it is known whether the vertical offsets are lacking, the elevations make up for them, right at one distance only.
    beam.elevation_applied = beam.elevation_applied || (vertical_settled_ && beam.elevation_sigma < params_.elevation_sigma * degree);
  }
  calibration->vertical_share = vertical_share_;
  calibration->vertical_sigma = vertical_sigma_;
  calibration->vertical_settled = !calibration->vertical_offsets.empty() && vertical_settled_;
  calibration->vertical_applied = calibration->vertical_settled && prior_mean_[2 * rings_] > 0.5;
  if (!decided_) decide(errs);
}

// Once: what was mapped before is mapped again with it, and from then on map and scans agree. Offsets that followed each new estimate would have them
// disagree again. Elevations stay: from one height above the floor they can't be told from the vertical offsets of the lasers.
void RingCalibrator::decide(bool errs) {
  const auto& beams = calibration_->beams;
  const auto known = [&](std::size_t ring) { return !counts_[ring] || beams[ring].range_sigma < params_.range_sigma; };
  bool all = true;
  for (std::size_t ring = 0; ring < beams.size(); ++ring) all = all && known(ring);
  if (scans_ < least_scans || (errs && !all && scans_ < most_scans)) return;
  decided_ = true;
  if (!errs) return;
  auto next = std::make_shared<RingCalibration>(*taken_out_);  // which takes nothing out yet
  for (std::size_t ring = 0; ring < beams.size(); ++ring) {
    next->beams[ring].range_offset = beams[ring].range_offset;
    next->beams[ring].range_applied = beams[ring].range_applied;
  }
  next->vertical_applied = calibration_->vertical_applied;
  if (next->corrects()) next_ = next;
}

void RingCalibrator::begin_to_take_out() {
  for (std::size_t ring = 0; ring < next_->beams.size(); ++ring) {
    const BeamCalibration& beam = next_->beams[ring];
    applied_[static_cast<Eigen::Index>(ring)] = beam.range_applied ? beam.range_offset : 0.0;
  }
  applied_[2 * rings_] = next_->vertical_applied ? 1.0 : 0.0;
  added_ = taken_out_ = std::move(next_);
}

// The offsets are lacking or they aren't: what the data says three times in a row is taken for true. It must say one of the two: with the errors of
// an odometry's poses in a long corridor it has said -3 with a standard deviation of 0.2, on its way through 0 later (docs/sensors.md).
void RingCalibrator::settle_vertical(double share, double sigma) {
  constexpr double neither = 4;  // standard deviations from both
  if (scans_ >= least_scans && std::min(std::abs(share), std::abs(share - 1)) > neither * sigma) vertical_contradicted_ = true;
  if (vertical_contradicted_) return;
  const double answer = share > 0.5 ? 1.0 : 0.0;
  const bool tells = scans_ >= least_scans && sigma < vertical_told && std::abs(share - answer) < 2 * sigma;
  const int vote = !tells ? 0 : answer > 0 ? 1 : -1;
  vertical_votes_ = vote == 0 ? 0 : vote * vertical_votes_ > 0 ? vertical_votes_ + vote : vote;
  if (std::abs(vertical_votes_) >= 3) settle_vertical_as(answer);
}

// Beams that err in range are a real VLP-16's, and each of its lasers has its place on the axis: a cloud of it in which all beams start at one point
// lacks that. A simulated sensor has beams without errors.
void RingCalibrator::settle_vertical_as(double share) {
  vertical_settled_ = true;
  prior_mean_[2 * rings_] = share;
  prior_weight_[2 * rings_] = fixed_weight;
}

}  // namespace sgraph
