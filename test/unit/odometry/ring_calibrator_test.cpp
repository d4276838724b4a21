#include "sgraph_slam/core/odometry/ring_calibrator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "sgraph_slam/core/sensor/ring_table.hpp"
#include "sgraph_slam/core/util/rng.hpp"

namespace sgraph {
namespace {

constexpr double degree = M_PI / 180;

struct Unit {
  std::vector<double> range = std::vector<double>(16, 0.0);      // [m]
  std::vector<double> elevation = std::vector<double>(16, 0.0);  // [rad]
  double share = 0;                                              // of the vertical offsets that the cloud lacks
  double noise = 0.007;                                          // [m]
};

Unit unit_of(std::uint64_t seed, double share) {
  RandomStream random(seed, 5);
  Unit unit;
  unit.share = share;
  double mean = 0;
  for (std::size_t k = 0; k < 16; ++k) {
    unit.range[k] = 0.006 * random.next_normal();
    unit.elevation[k] = 0.03 * degree * random.next_normal();
    mean += unit.range[k] / 16;
  }
  for (double& offset : unit.range) offset -= mean;
  return unit;
}

Unit without_range_errors(Unit unit) {
  unit.range.assign(16, 0.0);
  return unit;
}

// What the unit reports from a pose within a house of three rooms (boxes side by side along x, each its own height of ceiling).
Cloud scan_of(const Unit& unit, const Pose& pose, RandomStream& random) {
  Cloud cloud;
  cloud.stamp = Stamp::from_seconds(100);
  const double room = std::floor(pose.translation.x() / 7);
  const Eigen::Vector3d low(7 * room, 0, 0), high(7 * room + 6.8, 5.5, room == 1 ? 3.0 : 2.6);
  for (int column = 0; column < 360; ++column) {
    for (std::size_t k = 0; k < 16; ++k) {
      const double azimuth = -2 * M_PI * (column + 0.05 * static_cast<double>(k)) / 360;
      const double nominal = (-15 + 2 * static_cast<double>(k)) * degree;
      const auto ray = [&](double e) { return Eigen::Vector3d(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e)); };
      const Eigen::Vector3d direction = pose.rotation * ray(nominal + unit.elevation[k]);
      const Eigen::Vector3d origin = pose * Eigen::Vector3d(0, 0, unit.share * vlp16_vertical_offsets()[k]);
      double range = 1e9;
      for (int axis = 0; axis < 3; ++axis) {
        const double wall = direction[axis] > 0 ? high[axis] : low[axis];
        if (std::abs(direction[axis]) > 1e-9) range = std::min(range, (wall - origin[axis]) / direction[axis]);
      }
      Point point;
      point.set_position(((range + unit.range[k] + unit.noise * random.next_normal()) * ray(nominal)).cast<float>());
      point.ring = static_cast<std::uint16_t>(k);
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

CalibrationParams estimating() {
  CalibrationParams params;
  params.mode = "auto";
  return params;
}

// Walks up and down through the rooms, with the sensor higher and lower by `swing`; the odometry is off by a few millimetres.
std::shared_ptr<const RingCalibration> walked(const Unit& unit, int steps, const CalibrationParams& params = estimating(), double swing = 0) {
  RingCalibrator calibrator(params);
  RandomStream random(3, 1);
  for (int step = 0; step < steps; ++step) {
    const double way = 0.25 * step;
    const double x = std::abs(std::remainder(way + 1, 38.0)) + 1;
    Pose pose;
    pose.translation = {std::min(x, 19.5), 2.7 + 1.6 * std::sin(0.4 * way), 0.9 + swing * std::sin(0.15 * way)};
    pose.rotation = Eigen::AngleAxisd(0.5 * way, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(0.01 * std::sin(way), Eigen::Vector3d::UnitX());
    const auto raw = std::make_shared<Cloud>(scan_of(unit, pose, random));
    calibrator.recognise(*raw);
    Pose estimate = pose;
    estimate.translation += 0.002 * Eigen::Vector3d(random.next_normal(), random.next_normal(), random.next_normal());
    calibrator.add(*calibrator.taken_out()->corrected(raw), estimate);
  }
  return calibrator.calibration();
}

double range_error(const RingCalibration& calibration, const Unit& unit) {
  double squares = 0;
  for (std::size_t k = 0; k < 16; ++k) squares += std::pow(calibration.beams[k].range_offset - unit.range[k], 2);
  return std::sqrt(squares / 16);
}

TEST(RingCalibrator, FindsTheOffsetsOfAUnit) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Unit unit = unit_of(seed, 1);
    const auto calibration = walked(unit, 400, estimating(), 0.6);
    ASSERT_EQ(calibration->beams.size(), 16U);
    EXPECT_LT(range_error(*calibration, unit), 0.001);
    for (std::size_t k = 0; k < 16; ++k) {
      const BeamCalibration& beam = calibration->beams[k];
      EXPECT_TRUE(beam.range_applied);
      EXPECT_LT(std::abs(beam.range_offset - unit.range[k]), 4 * beam.range_sigma);
      EXPECT_LT(std::abs(beam.elevation_offset - unit.elevation[k]), 4 * beam.elevation_sigma);
    }
    // What stretches the building in height can't be told; the beams that see the floor agree with each other.
    const auto error = [&](std::size_t k) { return calibration->beams[k].elevation_offset - unit.elevation[k]; };
    for (std::size_t k = 1; k < 3; ++k) EXPECT_LT(std::abs(error(k) - error(0)), 0.01 * degree) << k;
  }
}

// The beams of a simulated sensor have no errors, those of a real one do; and all lasers of a real VLP-16 have their own places on the axis.
TEST(RingCalibrator, BeamsThatErrAreARealSensors) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Unit unit = unit_of(seed, 1);
    EXPECT_FALSE(walked(unit, 30)->vertical_settled);
    const auto calibration = walked(unit, 120);
    EXPECT_TRUE(calibration->vertical_settled);
    EXPECT_TRUE(calibration->vertical_applied);
    EXPECT_LT(range_error(*calibration, unit), 0.001);
  }
}

TEST(RingCalibrator, WhatTheUserKnowsOfTheVerticalOffsetsHolds) {
  CalibrationParams params = estimating();
  params.vertical = "lacking";
  EXPECT_TRUE(walked(unit_of(1, 1), 2, params)->vertical_applied) << "from the first scan";
  params.vertical = "present";
  const auto present = walked(unit_of(1, 0), 120, params);
  EXPECT_FALSE(present->vertical_applied);
  EXPECT_TRUE(present->vertical_settled);
  EXPECT_LT(range_error(*present, unit_of(1, 0)), 0.001);
}

// From several heights above the floor a beam meets it at several distances: that tells its vertical offset from its elevation.
TEST(RingCalibrator, WithoutErrorsTheDataTellsWhatIsLacking) {
  for (const double share : {0.0, 1.0}) {
    const auto calibration = walked(without_range_errors(unit_of(1, share)), 400, estimating(), 0.6);
    EXPECT_TRUE(calibration->vertical_settled) << calibration->vertical_share << " " << calibration->vertical_sigma;
    EXPECT_EQ(calibration->vertical_applied, share > 0.5) << calibration->vertical_share << " " << calibration->vertical_sigma;
  }
}

TEST(RingCalibrator, AUnitWithoutErrorsComesOutAsOne) {
  Unit unit;
  unit.noise = 0.02;
  const auto calibration = walked(unit, 400);
  for (const BeamCalibration& beam : calibration->beams) {
    EXPECT_LT(std::abs(beam.range_offset), 0.0012);  // three standard deviations with a noise of 2 cm
    EXPECT_FALSE(beam.range_applied) << "what is that small may be the estimate's own error";
    if (beam.elevation_applied) {
      EXPECT_LT(std::abs(beam.elevation_offset), 0.015 * degree);
    }
  }
  EXPECT_FALSE(calibration->vertical_applied);
}

// From one height above the floor, elevations make up for vertical offsets that the cloud lacks; elsewhere they would be wrong.
TEST(RingCalibrator, ElevationsWaitForTheVerticalOffsets) {
  for (const double share : {0.0, 1.0}) {
    const auto calibration = walked(without_range_errors(unit_of(1, share)), 400);
    ASSERT_EQ(calibration->beams.size(), 16U);
    EXPECT_FALSE(calibration->vertical_settled);
    EXPECT_FALSE(calibration->vertical_applied);
    EXPECT_NE(calibration->text().find("vertical offsets not settled"), std::string::npos) << calibration->text();
    for (const BeamCalibration& beam : calibration->beams) EXPECT_FALSE(beam.elevation_applied);
  }
}

TEST(RingCalibrator, NothingIsTakenOutBeforeTheDataHoldsIt) {
  const auto calibration = walked(unit_of(1, 1), 30);
  EXPECT_FALSE(calibration->corrects());
  CalibrationParams off;
  off.mode = "off";
  EXPECT_FALSE(walked(unit_of(1, 1), 100, off)->corrects());
}

// What is taken out is decided once: map and scans agree only as long as it stays what it is.
TEST(RingCalibrator, DecidesOnceWhatItTakesOut) {
  RingCalibrator calibrator(estimating());
  RandomStream random(3, 1);
  const Unit unit = unit_of(1, 1);
  int changes = 0;
  std::shared_ptr<const RingCalibration> added;
  for (int step = 0; step < 200; ++step) {
    Pose pose;
    pose.translation = {1 + 0.05 * step, 2.7 + 1.6 * std::sin(0.1 * step), 0.9};
    const auto raw = std::make_shared<Cloud>(scan_of(unit, pose, random));
    const bool decided = calibrator.decided();
    calibrator.recognise(*raw);
    if (calibrator.added()) {
      EXPECT_TRUE(decided);
      added = calibrator.added();
      ++changes;
    }
    EXPECT_EQ(calibrator.taken_out()->corrects(), changes > 0);
    calibrator.add(*calibrator.taken_out()->corrected(raw), pose);
  }
  EXPECT_TRUE(calibrator.decided());
  ASSERT_EQ(changes, 1);
  EXPECT_LT(range_error(*added, unit), 0.002);  // the scans of before lack all of it
  EXPECT_LT(range_error(*calibrator.taken_out(), unit), 0.002);
  EXPECT_LT(range_error(*calibrator.calibration(), unit), 0.001) << "with 200 scans it is known better than with the first";
}

TEST(RingCalibrator, EstimatesWithoutTakingOut) {
  CalibrationParams params;
  params.mode = "estimate";
  RingCalibrator calibrator(params);
  RandomStream random(3, 1);
  const Unit unit = unit_of(1, 1);
  for (int step = 0; step < 80; ++step) {
    Pose pose;
    pose.translation = {1 + 0.05 * step, 2.7 + 1.6 * std::sin(0.1 * step), 0.9};
    const Cloud raw = scan_of(unit, pose, random);
    calibrator.recognise(raw);
    calibrator.add(raw, pose);
    EXPECT_FALSE(calibrator.taken_out()->corrects());
  }
  EXPECT_TRUE(calibrator.calibration()->corrects());
  EXPECT_LT(range_error(*calibrator.calibration(), unit), 0.002);
}

TEST(RingCalibrator, SavedAndTakenUpAgain) {
  const Unit unit = unit_of(2, 1);
  const auto calibration = walked(unit, 400);
  const std::string path = testing::TempDir() + "calibration.yaml";
  std::ofstream(path) << to_yaml(*calibration);
  const RingCalibration read = read_calibration(path);
  ASSERT_EQ(read.beams.size(), 16U);
  for (std::size_t k = 0; k < 16; ++k) {
    EXPECT_NEAR(read.beams[k].range_offset, calibration->beams[k].range_offset, 1e-6);
    EXPECT_EQ(read.beams[k].elevation_applied, calibration->beams[k].elevation_applied);
  }
  CalibrationParams fixed;
  fixed.mode = "fixed";
  fixed.file = path;
  EXPECT_LT(range_error(*walked(unit, 5, fixed), unit), 0.001);
  CalibrationParams on = estimating();
  on.file = path;
  const auto again = walked(unit, 30, on);
  EXPECT_TRUE(again->corrects());
  EXPECT_LT(range_error(*again, unit), 0.001);

  std::ofstream(path) << "beams: nothing\n";
  EXPECT_THROW(read_calibration(path), std::runtime_error);
  EXPECT_THROW(read_calibration("/nowhere/at/all.yaml"), std::runtime_error);
}

TEST(RingCalibration, TakesTheOffsetsOut) {
  RingCalibration calibration;
  calibration.beams.resize(16);
  calibration.beams[3] = {0.01, 0, true, 0.001, 0, true};
  auto cloud = std::make_shared<Cloud>();
  Point p;
  p.set_position({3, 4, 0});
  p.ring = 3;
  cloud->points = {p, p};
  cloud->points[1].ring = 4;
  const CloudPtr corrected = calibration.corrected(cloud);
  EXPECT_NEAR(corrected->points[0].position().norm(), 4.99F, 1e-5F);
  EXPECT_NEAR(corrected->points[0].z, 4.99F * 0.001F, 1e-6F);
  EXPECT_EQ(corrected->points[1].position(), p.position());
}

}  // namespace
}  // namespace sgraph
