#include "sgraph_slam/core/segmentation/plane_segmenter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "sgraph_slam/core/math/noise.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/util/rng.hpp"
#include "support/static_scan.hpp"

namespace sgraph {
namespace {

using test::box;
using test::keyframe_scan;
using test::rectangle;
using test::static_scan;
using Surfaces = std::vector<sim::Surface>;

const Eigen::Vector3d X = Eigen::Vector3d::UnitX(), Y = Eigen::Vector3d::UnitY(), Z = Eigen::Vector3d::UnitZ();

Pose pose_at_yaw(const Eigen::Vector3d& position, double yaw, double roll = 0, double pitch = 0) {
  return {so3_exp(yaw * Z) * so3_exp(pitch * Y) * so3_exp(roll * X), position};
}

// Ten poses of a walk of 0.75 m that ends at `end`, swaying as a robot does.
std::vector<Pose> walk(const Pose& end) {
  std::vector<Pose> poses;
  for (int k = 9; k >= 0; --k) {
    Vector6 back;
    back << 0.012 * std::sin(1.3 * k), 0.015 * std::sin(0.9 * k), -0.01 * k, -0.075 * k, 0.01 * std::sin(k), 0.008 * std::sin(1.7 * k);
    poses.push_back(end * se3_exp(back));
  }
  return poses;
}

void add(Surfaces& surfaces, const Surfaces& more) { surfaces.insert(surfaces.end(), more.begin(), more.end()); }

double degrees_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI; }

// Segments of the face `plane_world` (within 2 degrees and 6 cm at their centroids).
std::vector<PlaneSegment> segments_of(const PlaneSegments& all, const Plane& plane_world, const Pose& T_world_lidar) {
  const Plane expected = T_world_lidar.inverse() * plane_world;
  std::vector<PlaneSegment> found;
  for (const PlaneSegment& s : all.segments) {
    if (degrees_between(s.plane.normal, expected.normal) < 2 && std::abs(expected.distance(s.centroid)) < 0.06) found.push_back(s);
  }
  return found;
}

double length_of(const PlaneSegment& segment) {
  double length = 0;
  for (const auto& a : segment.extent) {
    for (const auto& b : segment.extent) length = std::max(length, (a - b).norm());
  }
  return length;
}

const Eigen::Vector3d room_low(-4, -3, 0), room_high(4, 3, 2.2);
std::vector<Plane> room_faces() { return {{X, 4}, {-X, 4}, {Y, 3}, {-Y, 3}, {Z, 0}, {-Z, 2.2}}; }

void expect_consistent(const PlaneSegments& result, const std::vector<int>& labels, const Cloud& cloud) {
  ASSERT_EQ(labels.size(), cloud.size());
  std::vector<int> count(result.segments.size(), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    ASSERT_GE(labels[i], -1);
    ASSERT_LT(labels[i], static_cast<int>(result.segments.size()));
    if (labels[i] < 0) continue;
    ++count[static_cast<std::size_t>(labels[i])];
    EXPECT_LT(std::abs(result.segments[static_cast<std::size_t>(labels[i])].plane.distance(cloud.points[i].position().cast<double>())), 0.121);
  }
  for (std::size_t s = 0; s < result.segments.size(); ++s) {
    const PlaneSegment& segment = result.segments[s];
    EXPECT_GE(count[s], segment.count);
    EXPECT_LE(segment.count, result.segments[s > 0 ? s - 1 : 0].count);
    EXPECT_NEAR(segment.plane.normal.norm(), 1, 1e-9);
    EXPECT_EQ(segment.scatter(3, 3), segment.count);
    EXPECT_NEAR((segment.scatter.topRightCorner<3, 1>() / segment.count - segment.centroid).norm(), 0, 1e-9);
    Eigen::Vector4d homogeneous;
    homogeneous << segment.plane.normal, segment.plane.d;
    EXPECT_NEAR(std::sqrt(homogeneous.dot(segment.scatter * homogeneous) / segment.count), segment.sigma, 1e-6);
    EXPECT_GT(segment.covariance.determinant(), 0);
    ASSERT_GE(segment.extent.size(), 3U);
    for (std::size_t i = 0; i < segment.extent.size(); ++i) {
      const auto& a = segment.extent[i];
      const auto& b = segment.extent[(i + 1) % segment.extent.size()];
      const auto& c = segment.extent[(i + 2) % segment.extent.size()];
      EXPECT_NEAR(segment.plane.distance(a), 0, 1e-4);
      EXPECT_GT((b - a).cross(c - b).dot(segment.plane.normal), -1e-9) << "convex, counter-clockwise about the normal";
      EXPECT_GT((b - a).cross(segment.centroid - a).dot(segment.plane.normal), 0) << "around the centroid";
    }
  }
}

// An empty room, standing at several places and tilts, with noise from 5 mm to 4 cm: its six sides, each once, nothing else.
class EmptyRoom : public ::testing::TestWithParam<double> {};

TEST_P(EmptyRoom, GivesItsSixSides) {
  const double noise = GetParam();
  const sim::Scene scene(box(room_low, room_high));
  RandomStream random(11, 0);
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Eigen::Vector3d position(3 * (random.next_uniform() - 0.5), 2 * (random.next_uniform() - 0.5), 1.0 + 0.2 * random.next_uniform());
    const Pose pose = pose_at_yaw(position, 6.28 * random.next_uniform(), 0.03 * random.next_normal(), 0.03 * random.next_normal());
    const Cloud scan = keyframe_scan(scene, walk(pose), noise, seed);
    std::vector<int> labels;
    const PlaneSegments result = PlaneSegmenter({}).process(scan, &labels);
    EXPECT_EQ(result.stamp, scan.stamp);
    expect_consistent(result, labels, scan);
    std::size_t all = 0;
    for (const Plane& face : room_faces()) {
      const auto found = segments_of(result, face, pose);
      all += found.size();
      // A VLP-16 may see floor and ceiling in far corners only: pieces too far apart to be one.
      const bool wall = face.normal.z() == 0;
      EXPECT_TRUE(found.size() == 1 || (!wall && found.size() > 1)) << "noise " << noise << " seed " << seed << " face " << face.normal.transpose();
      const Plane expected = pose.inverse() * face;
      for (const PlaneSegment& s : found) {
        EXPECT_GT(s.plane.d, 0);
        const double deviation = std::sqrt(s.covariance.topLeftCorner<2, 2>().trace()) * 180 / M_PI;
        EXPECT_LT(degrees_between(s.plane.normal, expected.normal), wall ? 0.05 + 7 * noise : 0.05 + 5 * deviation);
        EXPECT_LT(std::abs(expected.distance(s.centroid)), 0.001 + 0.15 * noise);
        EXPECT_LT(s.sigma, 1.3 * noise + 0.001);
      }
    }
    EXPECT_EQ(result.segments.size(), all) << "nothing else, noise " << noise << " seed " << seed;
    const auto labelled = std::count_if(labels.begin(), labels.end(), [](int l) { return l >= 0; });
    EXPECT_GT(static_cast<double>(labelled), 0.95 * static_cast<double>(labels.size()));
  }
}

INSTANTIATE_TEST_SUITE_P(Noise, EmptyRoom, ::testing::Values(0.005, 0.01, 0.02, 0.03, 0.04));

TEST(PlaneSegmenter, FindsTheWallsInASingleScan) {
  const sim::Scene scene(box(Eigen::Vector3d(-8, -5, 0), Eigen::Vector3d(8, 5, 3)));
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Pose pose = pose_at_yaw({-2, 1, 0.8}, 0.4 * static_cast<double>(seed), 0.02, -0.03);
    const PlaneSegments result = PlaneSegmenter({}).process(static_scan(scene, pose, 0.02, seed));
    for (const Plane& face : {Plane{X, 8}, Plane{-X, 8}, Plane{Y, 5}, Plane{-Y, 5}, Plane{Z, 0}}) {
      const auto found = segments_of(result, face, pose);
      ASSERT_EQ(found.size(), 1U) << "seed " << seed << " face " << face.normal.transpose();
      EXPECT_LT(degrees_between(found[0].plane.normal, (pose.inverse() * face).normal), 0.35);
    }
  }
}

// A scan by a sensor whose beams have errors of their own.
Cloud with_beam_errors(Cloud scan, std::uint64_t unit) {
  RandomStream random(unit, 7);
  std::map<std::uint16_t, Eigen::Vector2d> errors;  // of range [m] and elevation [rad]
  for (Point& point : scan.points) {
    const auto [error, is_new] = errors.try_emplace(point.ring, Eigen::Vector2d::Zero());
    if (is_new) error->second = {noise::beam_range * random.next_normal(), noise::beam_elevation * random.next_normal()};
    const Eigen::Vector3d p = point.position().cast<double>();
    const double flat = p.head<2>().norm();
    const double range = p.norm() + error->second.x();
    const double elevation = std::atan2(p.z(), flat) + error->second.y();
    const Eigen::Vector2d level = range * std::cos(elevation) / flat * p.head<2>();
    point.set_position(Eigen::Vector3d(level.x(), level.y(), range * std::sin(elevation)).cast<float>());
  }
  return scan;
}

// Normalised squared errors of a room's walls and floor over many scans: 3 on average for a right covariance.
double mean_normalised_error(bool beams) {
  const sim::Scene scene(box(room_low, {4, 3, 3.5}));
  const Pose pose = pose_at_yaw({1, -0.5, 0.8}, 0.3, 0.02, 0.01);
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Cloud ideal = static_scan(scene, pose, beams ? 0.006 : 0.02, seed);
    const PlaneSegments result = PlaneSegmenter({}).process(beams ? with_beam_errors(ideal, seed) : ideal);
    for (const Plane& face : room_faces()) {
      const Plane expected = pose.inverse() * face;
      for (const PlaneSegment& s : segments_of(result, face, pose)) {
        Eigen::Vector3d error;
        error << tangent_basis(s.plane.normal).transpose() * expected.normal, expected.d - s.plane.d;
        sum += error.dot(s.covariance.inverse() * error);
        ++count;
      }
    }
  }
  EXPECT_GE(count, 195) << "the ceiling is out of sight";
  return sum / count;
}

TEST(PlaneSegmenter, CovarianceTellsTheErrorsOfBeams) {
  // With the points taken for independent it would be over 100.
  const double error = mean_normalised_error(true);
  EXPECT_GT(error, 1.5);
  EXPECT_LT(error, 4.5);
}

TEST(PlaneSegmenter, CovarianceIsNoWorseThanTheBeamsOfAnIdealSensorCouldBe) {
  const double error = mean_normalised_error(false);
  EXPECT_GT(error, 0.1);
  EXPECT_LT(error, 3.0);
}

TEST(PlaneSegmenter, FurnitureDoesNotBendWalls) {
  Surfaces surfaces = box(room_low, room_high);
  add(surfaces, box({-1.5, 2.55, 0}, {0.5, 2.99, 1.9}));       // cupboard on the wall at y = 3, its front 0.45 m before it
  add(surfaces, box({-3.5, -2.2, 0.72}, {-2.0, -1.4, 0.75}));  // table top
  add(surfaces, box({1.5, -2.97, 1.2}, {2.5, -2.94, 1.8}));    // picture, 6 cm before the wall
  const sim::Scene scene(surfaces);
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Pose pose = pose_at_yaw({0.5, -0.3, 1.2}, 1.0 * static_cast<double>(seed));
    const Cloud scan = keyframe_scan(scene, walk(pose), 0.02, seed);
    const PlaneSegments result = PlaneSegmenter({}).process(scan);
    for (const Plane& face : room_faces()) {
      const auto found = segments_of(result, face, pose);
      ASSERT_GE(found.size(), 1U);
      const Plane expected = pose.inverse() * face;
      EXPECT_LT(degrees_between(found[0].plane.normal, expected.normal), 0.15) << face.normal.transpose();
      EXPECT_LT(std::abs(expected.distance(found[0].centroid)), 0.004) << face.normal.transpose();
    }
    EXPECT_EQ(segments_of(result, {-Y, 2.55}, pose).size(), 1U) << "the cupboard's front";
    for (const PlaneSegment& s : result.segments) EXPECT_GT(length_of(s), 0.6);
  }
}

TEST(PlaneSegmenter, KeepsTheFacesOfAWallApart) {
  // Through the door of a wall 10 cm thick, into a second room: both faces are seen within one keyframe.
  for (const double thickness : {0.08, 0.12, 0.25}) {
    Surfaces surfaces = box({-5, -3, 0}, {5, 3, 2.8});
    add(surfaces, box({-thickness, 0.5, 0}, {0, 3, 2.8}));
    add(surfaces, box({-thickness, -3, 0}, {0, -0.5, 2.8}));
    const sim::Scene scene(surfaces);
    for (const double end : {0.2, 0.4, 0.6}) {
      std::vector<Pose> poses;
      for (int k = 0; k < 12; ++k)
        poses.push_back(pose_at_yaw({end - 0.08 * (11 - k), 0.02 * k, 0.9}, 0.01 * k, 0.01 * std::sin(k), 0.012 * std::cos(k)));
      const Cloud scan = keyframe_scan(scene, poses, 0.02, 5);
      const PlaneSegments result = PlaneSegmenter({}).process(scan);
      const auto near = segments_of(result, {X, 0}, poses.back());
      const auto far = segments_of(result, {-X, -thickness}, poses.back());
      ASSERT_EQ(near.size(), 1U) << "one segment on both sides of the door, thickness " << thickness << " end " << end;
      ASSERT_EQ(far.size(), 1U) << "thickness " << thickness << " end " << end;
      EXPECT_GT(near[0].plane.d, 0);
      EXPECT_LT(far[0].plane.d, 0) << "the LiDAR has passed it";
      EXPECT_LT(std::abs((poses.back().inverse() * Plane{X, 0}).distance(near[0].centroid)), 0.01);
      EXPECT_LT(std::abs((poses.back().inverse() * Plane{-X, -thickness}).distance(far[0].centroid)), 0.01);
    }
  }
}

TEST(PlaneSegmenter, JoinsAWallAcrossADoorButNotAcrossAHall) {
  for (const auto& [gap, expected] : {std::pair{1.0, 1}, std::pair{1.8, 1}, std::pair{3.5, 2}}) {
    Surfaces surfaces{rectangle({3, gap / 2, 0}, 4 * Y, 2.8 * Z), rectangle({3, -gap / 2, 0}, -4 * Y, 2.8 * Z),
                      rectangle({-6, -8, 0}, 20 * X, 16 * Y)};
    const sim::Scene scene(surfaces);
    const Pose pose = pose_at_yaw({0, 0.2, 1}, 0.2);
    const Cloud scan = keyframe_scan(scene, walk(pose), 0.02, 3);
    EXPECT_EQ(segments_of(PlaneSegmenter({}).process(scan), {-X, 3}, pose).size(), static_cast<std::size_t>(expected)) << gap;
  }
}

TEST(PlaneSegmenter, DoesNotJoinWallsThatAreOffset) {
  const double offset = 0.05;  // under the threshold of the inliers, over what the noise allows
  const sim::Scene scene({rectangle({3, 0.5, 0}, 4 * Y, 2.8 * Z), rectangle({3 + offset, -0.5, 0}, -4 * Y, 2.8 * Z)});
  const Pose pose = pose_at_yaw({0, 0.2, 1}, 0.2);
  const Cloud scan = keyframe_scan(scene, walk(pose), 0.02, 4);
  const PlaneSegments result = PlaneSegmenter({}).process(scan);
  ASSERT_EQ(result.segments.size(), 2U);
  for (const double x : {3.0, 3.0 + offset}) {
    const Plane expected = pose.inverse() * Plane{-X, x};
    EXPECT_TRUE(std::any_of(result.segments.begin(), result.segments.end(), [&](const PlaneSegment& s) {
      return std::abs(expected.distance(s.centroid)) < 0.004;
    })) << x;
  }
}

// Shelves whose backs stand 7 cm before a wall, over half of it: less than the inliers' limit to both sides. Their mean is neither.
TEST(PlaneSegmenter, AShelfBeforeAWallIsNoPartOfIt) {
  const sim::Scene scene({rectangle({3, -3, 0}, 6 * Y, 2.8 * Z), rectangle({2.93, -2.0, 0}, 1.2 * Y, 1.9 * Z),
                          rectangle({2.93, 0.2, 0}, 1.2 * Y, 1.9 * Z), rectangle({-4, -4, 0}, 8 * X, 8 * Y)});
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Pose pose = pose_at_yaw({-0.5, 0.4 * static_cast<double>(seed) - 1, 1}, 0.3 * static_cast<double>(seed));
    const Cloud scan = keyframe_scan(scene, walk(pose), 0.02, seed);
    const Plane expected = pose.inverse() * Plane{-X, 3};
    double longest = 0, angle = 0, offset = 0;
    for (const PlaneSegment& s : PlaneSegmenter({}).process(scan).segments) {
      if (degrees_between(s.plane.normal, expected.normal) > 5 || length_of(s) < longest) continue;
      longest = length_of(s);
      angle = degrees_between(s.plane.normal, expected.normal);
      offset = expected.distance(s.centroid);
    }
    EXPECT_GT(longest, 5) << seed;
    EXPECT_LT(std::abs(offset), 0.006) << seed;
    EXPECT_LT(angle, 0.25) << seed;
  }
}

// The reveals at both sides of a wide opening, seen from afar: two strips as wide as the wall is thick, far apart. No wall stands in the opening.
TEST(PlaneSegmenter, TheEdgesOfAnOpeningAreNoPlaneAcrossIt) {
  Surfaces surfaces;
  for (const double y : {-0.9, 0.9}) add(surfaces, {rectangle({7.92, y, 0}, 0.15 * X, 2.8 * Z)});
  const sim::Scene scene(surfaces);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Cloud scan = keyframe_scan(scene, walk(pose_at_yaw({0.5 * static_cast<double>(seed), 0.3, 1}, 0)), 0.02, seed);
    for (const PlaneSegment& s : PlaneSegmenter({}).process(scan).segments) EXPECT_LT(length_of(s), 1.7) << seed;
  }
}

TEST(PlaneSegmenter, LaysNoPlaneThroughUnrelatedFarWalls) {
  // Ends of walls that happen to lie on one plane, and two parallel rows of pillars: nothing there is a plane.
  Surfaces surfaces;
  for (int i = 0; i < 6; ++i) add(surfaces, box({-6.0 + 2.4 * i, 3, 0}, {-5.9 + 2.4 * i, 3.15, 3}));
  const sim::Scene scene(surfaces);
  const Pose pose = pose_at_yaw({0, 0, 1}, 0.1);
  const Cloud scan = keyframe_scan(scene, walk(pose), 0.02, 6);
  ASSERT_GT(scan.size(), 500U);
  EXPECT_TRUE(PlaneSegmenter({}).process(scan).segments.empty());
}

TEST(PlaneSegmenter, FindsNothingInClutter) {
  RandomStream random(8, 0);
  Cloud cloud;
  for (int i = 0; i < 15000; ++i) {
    Point p;
    p.x = static_cast<float>(1 + 4 * random.next_uniform());
    p.y = static_cast<float>(4 * random.next_uniform() - 2);
    p.z = static_cast<float>(3 * random.next_uniform() - 1);
    cloud.points.push_back(p);
  }
  EXPECT_TRUE(PlaneSegmenter({}).process(cloud).segments.empty());
}

TEST(PlaneSegmenter, LeavesNoGhostsBesideACorridorsWalls) {
  // Most of a long corridor's wall is seen at a grazing angle and looks flat to a few millimetres; its near end has the sensor's whole noise.
  const Eigen::Vector3d low(-4, -1, 0), high(20, 1, 2.6);
  const sim::Scene scene(box(low, high));
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Pose pose = pose_at_yaw({-1 + 0.5 * static_cast<double>(seed), 0.2, 0.9}, 0.3 * static_cast<double>(seed));
    const Cloud scan = keyframe_scan(scene, walk(pose), 0.025, seed);
    const PlaneSegments result = PlaneSegmenter({}).process(scan);
    for (const Plane& face : {Plane{Y, 1}, Plane{-Y, 1}}) {
      int near = 0;
      const Plane expected = pose.inverse() * face;
      for (const PlaneSegment& s : result.segments) {
        near += degrees_between(s.plane.normal, expected.normal) < 10 && std::abs(expected.distance(s.centroid)) < 0.3 ? 1 : 0;
      }
      EXPECT_EQ(near, 1) << "seed " << seed << " face " << face.normal.transpose();
      const auto found = segments_of(result, face, pose);
      ASSERT_EQ(found.size(), 1U);
      EXPECT_LT(degrees_between(found[0].plane.normal, expected.normal), 0.1);
      EXPECT_LT(std::abs(expected.distance(found[0].centroid)), 0.002);
    }
  }
}

TEST(PlaneSegmenter, SameCloudSameResult) {
  const sim::Scene scene(box(room_low, room_high));
  const Cloud scan = keyframe_scan(scene, walk(pose_at_yaw({1, 1, 1}, 0.5)), 0.02, 1);
  std::vector<int> labels_a, labels_b;
  const PlaneSegments a = PlaneSegmenter({}).process(scan, &labels_a);
  const PlaneSegments b = PlaneSegmenter({}).process(scan, &labels_b);
  EXPECT_EQ(labels_a, labels_b);
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t i = 0; i < a.segments.size(); ++i) {
    EXPECT_EQ(a.segments[i].plane.normal, b.segments[i].plane.normal);
    EXPECT_EQ(a.segments[i].plane.d, b.segments[i].plane.d);
    EXPECT_EQ(a.segments[i].covariance, b.segments[i].covariance);
  }
}

TEST(PlaneSegmenter, SurvivesBadPoints) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const auto point = [](float x, float y, float z) {
    Point p;
    p.x = x;
    p.y = y;
    p.z = z;
    return p;
  };
  std::vector<int> labels{1, 2, 3};
  EXPECT_TRUE(PlaneSegmenter({}).process(Cloud{}, &labels).segments.empty());
  EXPECT_TRUE(labels.empty());
  Cloud cloud;
  cloud.points.assign(500, point(1, 2, 3));
  EXPECT_TRUE(PlaneSegmenter({}).process(cloud).segments.empty());
  cloud.points.assign(500, point(nan, inf, 0));
  EXPECT_TRUE(PlaneSegmenter({}).process(cloud).segments.empty());
  cloud.points.clear();
  for (int i = 0; i < 500; ++i) cloud.points.push_back(point(0.01F * static_cast<float>(i), 2, 0));
  EXPECT_TRUE(PlaneSegmenter({}).process(cloud).segments.empty());

  const sim::Scene scene(box(room_low, room_high));
  const Pose pose = pose_at_yaw({0, 0, 0.8}, 0.2);
  Cloud room = static_scan(scene, pose, 0.02, 2);
  for (std::size_t i = 0; i < room.size(); i += 50) room.points[i] = point(i % 100 == 0 ? nan : 1e30F, inf, 0);
  room.points[7] = point(3e7F, -2e7F, 1e7F);
  const PlaneSegments result = PlaneSegmenter({}).process(room, &labels);
  for (const Plane& face : room_faces()) {
    EXPECT_EQ(segments_of(result, face, pose).size(), face.normal.z() < 0 ? 0U : 1U) << face.normal.transpose();
  }
  for (std::size_t i = 0; i < room.size(); i += 50) EXPECT_EQ(labels[i], -1);
}

TEST(PlaneSegmenter, RefusesParametersThatContradictEachOther) {
  SegmentationParams params;
  params.min_threshold = 0.2;
  EXPECT_THROW(PlaneSegmenter{params}, std::runtime_error);
  params = {};
  params.gap = 2;
  EXPECT_THROW(PlaneSegmenter{params}, std::runtime_error);
}

}  // namespace
}  // namespace sgraph
