#include "sgraph_slam/core/sim/simulator.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph::sim {

namespace {

constexpr std::int64_t scan_delay = 5'000'000;  // from its last firing until a cloud reaches the computer [ns]
constexpr std::int64_t reading_delay = 1'000'000;

double recorded(const Motion& motion, double wished) { return wished > 0 ? std::min(wished, motion.duration()) : motion.duration(); }

int scans_in(double duration, double rate) { return static_cast<int>(std::floor(duration * rate + 1e-9)); }

}  // namespace

SimulatedSource::SimulatedSource(const World& world, const SimulationSettings& settings)
    : SimulatedSource(world, motion_along_route(world), settings) {}

SimulatedSource::SimulatedSource(const World& world, Motion motion, const SimulationSettings& settings)
    : world_(world),
      motion_(std::move(motion)),
      settings_(settings),
      lidar_(
          world, [motion = motion_](double time) { return motion.pose_at(time); }, settings.lidar),
      duration_(recorded(motion_, settings.duration)),
      scan_count_(scans_in(duration_, settings.lidar.rate)),
      encoders_(simulate_encoders(motion_, duration_, settings.encoders, settings.lidar.seed, settings.lidar.start)),
      imu_(simulate_imu(motion_, duration_, settings.imu, settings.lidar.seed, settings.lidar.start)) {}

std::optional<SensorEvent> SimulatedSource::next() {
  constexpr auto never = Stamp{INT64_MAX};
  const Stamp encoder = next_encoder_ < encoders_.size() ? Stamp{encoders_[next_encoder_].sample.stamp.nanoseconds + reading_delay} : never;
  const Stamp imu = next_imu_ < imu_.size() ? Stamp{imu_[next_imu_].stamp.nanoseconds + reading_delay} : never;
  const Stamp scan = next_scan_ < scan_count_ ? Stamp{settings_.lidar.start + std::llround(lidar_.end_of(next_scan_) * 1e9) + scan_delay} : never;
  last_arrival_ = std::min({encoder, imu, scan});
  if (last_arrival_ == never) return std::nullopt;
  if (last_arrival_ == imu) return imu_[next_imu_++];
  if (last_arrival_ == encoder) return encoders_[next_encoder_++].sample;
  return std::make_shared<const Cloud>(lidar_.scan(next_scan_++));
}

Trajectory SimulatedSource::ground_truth() const {
  Trajectory truth;
  for (int k = 0; k < scan_count_; ++k) truth.push_back({lidar_.stamp_of(k), motion_.pose_at(lidar_.time_of(k))});
  return truth;
}

SimulatedScans simulate_scans(const World& world, int count, const LidarSettings& settings, int first) {
  const Motion motion = motion_along_route(world);
  const Lidar lidar(
      world, [&motion](double time) { return motion.pose_at(time); }, settings);
  SimulatedScans result;
  result.T_base_lidar = world.T_base_lidar;
  for (int k = first; k < std::min(first + count, scans_in(motion.duration(), settings.rate)); ++k) {
    result.scans.push_back(std::make_shared<const Cloud>(lidar.scan(k)));
    result.truth.push_back({lidar.stamp_of(k), motion.pose_at(lidar.time_of(k))});
  }
  return result;
}

}  // namespace sgraph::sim
