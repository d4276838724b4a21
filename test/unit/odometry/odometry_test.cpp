#include "sgraph_slam/core/odometry/odometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <random>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"
#include "support/static_scan.hpp"
#include "support/trajectory_error.hpp"

namespace sgraph {
namespace {

using test::ate;

struct Outcome {
  Trajectory live;
  Trajectory finals;
  std::vector<OdometryEstimate> estimates;
  std::vector<Keyframe> keyframes;
};

sim::SimulatedScans demo(int count, sim::LidarSettings settings = {}, int first = 0) {
  static const sim::World world = sim::read_world("worlds/demo.yaml");
  return sim::simulate_scans(world, count, settings, first);
}

void take(Outcome& run, const OdometryOutput& output) {
  run.finals.insert(run.finals.end(), output.finals.begin(), output.finals.end());
  run.keyframes.insert(run.keyframes.end(), output.keyframes.begin(), output.keyframes.end());
}

Outcome run_odometry(const std::vector<CloudPtr>& scans, const Pose& T_base_lidar, const OdometryParams& params = {}) {
  const Prefilter prefilter({});
  Odometry odometry(params, T_base_lidar);
  Outcome run;
  for (const CloudPtr& scan : scans) {
    const OdometryOutput output = odometry.process(prefilter.process(*scan).cloud);
    EXPECT_EQ(output.verdict, ScanVerdict::accepted);
    run.live.push_back({output.live.stamp, output.live.T_odom_base});
    run.estimates.push_back(output.live);
    take(run, output);
  }
  take(run, odometry.finish());
  return run;
}

TEST(Odometry, FollowsAWalkingRobotToMillimetres) {
  const auto scans = demo(180);
  const Outcome run = run_odometry(scans.scans, scans.T_base_lidar);
  EXPECT_LT(ate(run.finals, scans.truth), 0.007);
  EXPECT_LT(ate(run.live, scans.truth), 0.02);
  ASSERT_EQ(run.finals.size(), scans.scans.size());
  for (std::size_t i = 0; i < scans.scans.size(); ++i) EXPECT_EQ(run.finals[i].stamp, scans.scans[i]->stamp);
  EXPECT_GT(run.keyframes.size(), 5U);
}

// On the landing hardly a point lies on a floor or a step, and on the first step of the second flight the sensor tips by 30 degrees at once.
TEST(Odometry, ClimbsTwoFlightsWithALandingBetween) {
  sim::World world = sim::read_world("worlds/stairs.yaml");
  std::vector<sim::Waypoint>& way = world.route.waypoints;
  way = {way.begin() + 7, way.begin() + 20};  // from the ground floor's hall to that above
  world.route.stand = 1;
  const Prefilter prefilter({});
  std::unique_ptr<Odometry> odometry;
  Outcome run;
  Trajectory truth;
  for (int first = 0; first < 460; first += 46) {  // a piece of it in memory at a time
    const sim::SimulatedScans scans = sim::simulate_scans(world, 46, {}, first);
    if (!odometry) odometry = std::make_unique<Odometry>(OdometryParams{}, scans.T_base_lidar);
    for (const CloudPtr& scan : scans.scans) take(run, odometry->process(prefilter.process(*scan).cloud));
    truth.insert(truth.end(), scans.truth.begin(), scans.truth.end());
  }
  take(run, odometry->finish());
  EXPECT_GT(run.finals.back().pose.translation.z(), 2.9);
  EXPECT_LT(ate(run.finals, truth), 0.028);  // with eight seeds 0.012 to 0.023
}

TEST(Odometry, BothStampConventionsGiveTheSameMotion) {
  sim::LidarSettings settings;
  settings.stamp = sim::StampConvention::first;
  const auto first = demo(100, settings, 40);
  settings.stamp = sim::StampConvention::last;
  const auto last = demo(100, settings, 40);
  EXPECT_LT(ate(run_odometry(first.scans, first.T_base_lidar).finals, first.truth), 0.008);
  EXPECT_LT(ate(run_odometry(last.scans, last.T_base_lidar).finals, last.truth), 0.008);
}

TEST(Odometry, StartsWhileMoving) {
  const auto scans = demo(60, {}, 120);
  ASSERT_GT((scans.truth[20].pose.translation - scans.truth[0].pose.translation).norm(), 0.5) << "the robot must be under way";
  EXPECT_LT(ate(run_odometry(scans.scans, scans.T_base_lidar).finals, scans.truth), 0.009);
}

TEST(Odometry, WithoutPointTimesOnePoseAScan) {
  sim::LidarSettings settings;
  settings.motion_distortion = false;
  auto scans = demo(150, settings, 40);
  for (CloudPtr& scan : scans.scans) {
    auto timeless = std::make_shared<Cloud>(*scan);
    for (Point& point : timeless->points) point.time = 0;
    scan = timeless;
  }
  EXPECT_LT(ate(run_odometry(scans.scans, scans.T_base_lidar).finals, scans.truth), 0.008);
}

TEST(Odometry, TheMotionWithinTheScanIsWorthFinding) {
  const auto scans = demo(120, {}, 60);
  std::map<std::string, double> error;
  for (const char* model : {"window", "scan", "velocity", "none"}) {
    OdometryParams params;
    params.motion.model = model;
    const Outcome run = run_odometry(scans.scans, scans.T_base_lidar, params);
    ASSERT_EQ(run.finals.size(), scans.scans.size()) << model;
    for (std::size_t i = 0; i < run.finals.size(); ++i) EXPECT_EQ(run.finals[i].stamp, scans.scans[i]->stamp) << model;
    error[model] = ate(run.finals, scans.truth);
  }
  EXPECT_LT(error["window"], 0.007);
  EXPECT_GT(error["velocity"], 1.5 * error["window"]);
  EXPECT_GT(error["none"], 3 * error["window"]);
  EXPECT_LT(error["velocity"], 0.03) << "final poses come from the scans' middles";
  for (const auto& [model, rms] : error) EXPECT_LT(rms, 0.07) << model;
}

TEST(Odometry, FollowsWithTheResidualBetweenDistributions) {
  const auto scans = demo(80, {}, 60);
  OdometryParams params;
  params.motion.residual = "distribution";
  EXPECT_LT(ate(run_odometry(scans.scans, scans.T_base_lidar, params).finals, scans.truth), 0.008);
}

TEST(Odometry, TakesTheRangeNoiseFromTheData) {
  for (const double noise : {0.01, 0.04}) {
    sim::LidarSettings settings;
    settings.range_noise = noise;
    const auto scans = demo(100, settings, 40);
    const Outcome run = run_odometry(scans.scans, scans.T_base_lidar);
    EXPECT_LT(ate(run.finals, scans.truth), 0.003 + 0.25 * noise) << noise;
    EXPECT_GT(run.estimates.back().inlier_share, 0.4) << noise;
  }
}

TEST(Odometry, FollowsAtFiveAndTwentyHertz) {
  for (const double rate : {5.0, 20.0}) {
    sim::LidarSettings settings;
    settings.rate = rate;
    const auto scans = demo(static_cast<int>(8 * rate), settings, static_cast<int>(6 * rate));
    ASSERT_NEAR(scans.scans[1]->stamp - scans.scans[0]->stamp, 1 / rate, 1e-3);
    EXPECT_LT(ate(run_odometry(scans.scans, scans.T_base_lidar).finals, scans.truth), rate < 10 ? 0.02 : 0.012) << rate;
  }
}

// A tilted sensor, a hall: for two seconds only walls are seen, so nothing says how high it is.
TEST(Odometry, KeepsItsHeightWhileNeitherFloorNorCeilingIsInView) {
  const auto scans = demo(110, {}, 100);
  std::vector<CloudPtr> seen = scans.scans;
  for (std::size_t i = 40; i < 60; ++i) {
    const Pose T_world_lidar = scans.truth[i].pose * scans.T_base_lidar;
    auto walls = std::make_shared<Cloud>(*seen[i]);
    const auto level = [&](const Point& p) {
      const double z = (T_world_lidar * p.position().cast<double>()).z();
      return z < 0.15 || z > 2.45;
    };
    walls->points.erase(std::remove_if(walls->points.begin(), walls->points.end(), level), walls->points.end());
    ASSERT_GT(seen[i]->size(), walls->size() + 1000);
    seen[i] = walls;
  }
  const Outcome run = run_odometry(seen, scans.T_base_lidar);
  EXPECT_LT(ate(run.finals, scans.truth), 0.04) << "1 cm a 50 ms, which is what is believed of a sway, makes 6 cm in two seconds";
  EXPECT_LT(ate({run.finals.begin() + 70, run.finals.end()}, {scans.truth.begin() + 70, scans.truth.end()}), 0.006);
}

// What a calibration of the sensor learns from: one ring's range is off by 2 cm.
TEST(Odometry, HandsOverHowFarKeypointsLieFromTheirSurfaces) {
  auto scans = demo(60, {}, 60);
  const int wrong = scans.scans.front()->points[scans.scans.front()->size() / 2].ring;
  for (CloudPtr& scan : scans.scans) {
    auto off = std::make_shared<Cloud>(*scan);
    for (Point& p : off->points) {
      if (p.ring == wrong) p.set_position((p.position().norm() + 0.02F) / p.position().norm() * p.position());
    }
    scan = off;
  }
  const Prefilter prefilter({});
  Odometry odometry({}, scans.T_base_lidar);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();  // of the ring that is off, and of the others
  Eigen::Vector2d count = Eigen::Vector2d::Zero();
  int calls = 0;
  odometry.observe_residuals([&](Stamp, const std::vector<SurfaceResidual>& residuals) {
    ++calls;
    for (const SurfaceResidual& r : residuals) {
      EXPECT_NEAR(r.direction.norm(), 1, 1e-4);
      EXPECT_LT(r.normal.dot(r.direction), 0) << "the surface faces the sensor";
      if (-r.normal.dot(r.direction) < 0.7F) continue;
      sum[r.ring == wrong ? 0 : 1] += static_cast<double>(r.residual / -r.normal.dot(r.direction));
      count[r.ring == wrong ? 0 : 1] += 1;
    }
  });
  for (const CloudPtr& scan : scans.scans) odometry.process(prefilter.process(*scan).cloud);
  EXPECT_GT(calls, 55);
  ASSERT_GT(count.minCoeff(), 500);
  EXPECT_LT(sum[0] / count[0] - sum[1] / count[1], -0.008) << "too long a range lies behind the surface, which has learnt some of it";
}

TEST(Odometry, SameScansSameResult) {
  const auto scans = demo(40, {}, 60);
  const Outcome a = run_odometry(scans.scans, scans.T_base_lidar);
  const Outcome b = run_odometry(scans.scans, scans.T_base_lidar);
  for (std::size_t i = 0; i < a.finals.size(); ++i) {
    EXPECT_EQ(a.finals[i].pose.translation, b.finals[i].pose.translation);
    EXPECT_EQ(a.finals[i].pose.rotation.coeffs(), b.finals[i].pose.rotation.coeffs());
  }
}

// Mean rotation vector and translation of some poses that are nearly the same.
Vector6 mean_motion(const Trajectory& poses, std::size_t begin, std::size_t end) {
  Vector6 sum = Vector6::Zero();
  for (std::size_t i = begin; i < end; ++i) {
    sum.head<3>() += so3_log(poses[i].pose.rotation);
    sum.tail<3>() += poses[i].pose.translation;
  }
  return sum / static_cast<double>(end - begin);
}

TEST(Odometry, AStandstillDoesNotDrift) {
  const auto scans = demo(1);
  std::vector<CloudPtr> repeated;
  sim::LidarSettings settings;
  for (int i = 0; i < 200; ++i) {
    settings.seed = static_cast<std::uint64_t>(1 + i % 10);
    static std::vector<CloudPtr> noisy(10);
    CloudPtr& scan = noisy[static_cast<std::size_t>(i % 10)];
    if (scan == nullptr) scan = demo(1, settings).scans.front();
    auto copy = std::make_shared<Cloud>(*scan);
    copy->stamp = scans.scans.front()->stamp.after(0.1 * i);
    repeated.push_back(copy);
  }
  const Outcome run = run_odometry(repeated, scans.T_base_lidar);
  // Single scans scatter by the sensor's noise; drift shows in their mean.
  const Vector6 drift = mean_motion(run.finals, 180, 200) - mean_motion(run.finals, 10, 30);
  EXPECT_LT(drift.tail<3>().norm(), 0.002);
  EXPECT_LT(drift.head<3>().norm(), 0.02 * M_PI / 180);
}

TEST(Odometry, RefusesWhatCannotBeUsedAndGoesOn) {
  const auto scans = demo(30, {}, 60);
  const Prefilter prefilter({});
  Odometry odometry({}, scans.T_base_lidar);
  EXPECT_EQ(odometry.process(std::make_shared<Cloud>()).verdict, ScanVerdict::too_few_points);
  Trajectory live;
  for (std::size_t i = 0; i < scans.scans.size(); ++i) {
    const CloudPtr scan = prefilter.process(*scans.scans[i]).cloud;
    const OdometryOutput output = odometry.process(scan);
    ASSERT_EQ(output.verdict, ScanVerdict::accepted);
    EXPECT_TRUE(output.live.T_odom_base.translation.allFinite());
    EXPECT_TRUE(output.live.covariance.allFinite());
    live.push_back({output.live.stamp, output.live.T_odom_base});
    EXPECT_EQ(odometry.process(scan).verdict, ScanVerdict::not_later) << "a repeated message";
    const CloudPtr older = prefilter.process(*scans.scans[i > 0 ? i - 1 : 0]).cloud;
    EXPECT_EQ(odometry.process(older).verdict, ScanVerdict::not_later);
    if (i == 15) {
      auto few = std::make_shared<Cloud>(*scan);
      few->points.resize(5);
      few->stamp = few->stamp.after(0.05);
      EXPECT_EQ(odometry.process(few).verdict, ScanVerdict::too_few_points);
    }
  }
  EXPECT_LT(ate(live, scans.truth), 0.024);
}

// Scans that show something else entirely (a cover over the sensor) must not throw the pose away nor enter the map.
TEST(Odometry, BridgesScansThatTheMapCannotExplain) {
  auto scans = demo(80, {}, 60);
  for (std::size_t i = 30; i < 33; ++i) {
    auto cover = std::make_shared<Cloud>(*scans.scans[i]);
    for (Point& point : cover->points) {
      const float length = point.position().norm();
      point.x *= 1.0F / length;
      point.y *= 1.0F / length;
      point.z *= 1.0F / length;
    }
    scans.scans[i] = cover;
  }
  const Outcome run = run_odometry(scans.scans, scans.T_base_lidar);
  EXPECT_EQ(run.estimates[31].status, OdometryStatus::predicted);
  EXPECT_EQ(run.estimates[31].degenerate.size(), 6U) << "no direction of a predicted pose is held";
  EXPECT_GT(run.estimates[31].covariance(3, 3), 10 * run.estimates[28].covariance(3, 3)) << "the covariance is the prediction's";
  for (const Keyframe& keyframe : run.keyframes) EXPECT_LT(keyframe.degenerate.size(), 6U) << "scans before and after hold the keyframe's motion";
  EXPECT_EQ(run.estimates.back().status, OdometryStatus::tracked);
  EXPECT_LT(ate({run.live.begin(), run.live.begin() + 29}, scans.truth), 0.025);
  EXPECT_LT(ate(run.live, scans.truth), 0.03);
}

// Every fifth scan shows another place, has its axes mixed up or is noise: as good as if these had never come.
TEST(Odometry, ScansThatLieDoNoHarm) {
  const auto scans = demo(100, {}, 60);
  std::vector<CloudPtr> with_lies = scans.scans;
  std::vector<CloudPtr> without;
  Trajectory truth;
  std::mt19937 random(4);
  std::uniform_real_distribution<float> anywhere(-8, 8);
  for (std::size_t i = 0; i < with_lies.size(); ++i) {
    if (i < 10 || i % 5 != 0) {
      without.push_back(scans.scans[i]);
      truth.push_back(scans.truth[i]);
      continue;
    }
    auto lie = std::make_shared<Cloud>(*with_lies[i]);
    for (Point& p : lie->points) {
      const Eigen::Vector3f at = p.position();
      if (i % 3 == 0) p.set_position({at.z(), 3 * at.x(), at.y()});
      if (i % 3 == 1) p.set_position({anywhere(random), anywhere(random), 0.2F * anywhere(random)});
      if (i % 3 == 2) p.set_position(0.5F * at + Eigen::Vector3f(0, 1, 0));
    }
    with_lies[i] = lie;
  }
  const Outcome lied_to = run_odometry(with_lies, scans.T_base_lidar);
  Trajectory of_true_scans;
  for (std::size_t i = 0; i < with_lies.size(); ++i) {
    const bool lie = i >= 10 && i % 5 == 0;
    EXPECT_EQ(lied_to.estimates[i].status == OdometryStatus::predicted, lie) << i;
    if (!lie) of_true_scans.push_back(lied_to.finals[i]);
  }
  const double alone = ate(run_odometry(without, scans.T_base_lidar).finals, truth);
  EXPECT_LT(ate(of_true_scans, truth), alone + 0.001);
}

// Recordings thinned to save space, drivers that drop scans: half a second between sweeps of a tenth.
TEST(Odometry, FollowsThroughGapsBetweenTheScans) {
  const auto all = demo(300, {}, 40);
  std::vector<CloudPtr> some;
  Trajectory truth;
  for (std::size_t i = 0; i < all.scans.size(); i += 5) {
    some.push_back(all.scans[i]);
    truth.push_back(all.truth[i]);
  }
  const Outcome run = run_odometry(some, all.T_base_lidar);
  EXPECT_LT(ate(run.finals, truth), 0.04);
  ASSERT_EQ(run.finals.size(), some.size());
}

TEST(Odometry, ReportsTheDirectionAlongABareCorridorAndKeepsTheOthers) {
  sim::Scene scene(test::box({-90, -1.25, 0}, {90, 1.25, 2.6}));
  const Prefilter prefilter({});
  Odometry odometry({}, {});
  Trajectory finals;
  Trajectory truth;
  int reported = 0;
  for (int i = 0; i < 30; ++i) {
    const Pose pose{so3_exp({0, 0, 0.02 * std::sin(0.3 * i)}), {0.05 * i, 0.1 * std::sin(0.2 * i), 1.2}};
    auto scan = std::make_shared<Cloud>(test::static_scan(scene, pose, 0.02, static_cast<std::uint64_t>(i + 1)));
    scan->stamp = scan->stamp.after(0.1 * i);
    const OdometryOutput output = odometry.process(prefilter.process(*scan).cloud);
    finals.insert(finals.end(), output.finals.begin(), output.finals.end());
    truth.push_back({scan->stamp, pose});
    for (const Vector6& direction : output.live.degenerate) reported += std::abs(direction[3]) > 0.95;
  }
  EXPECT_GT(reported, 22);  // 25 are: now and then the noise of a scan looks like something to hold on to
  ASSERT_GT(finals.size(), 25U);
  for (std::size_t i = 0; i < finals.size(); ++i) {
    const Pose expected = truth.front().pose.inverse() * truth[i].pose;
    const Pose off = expected.inverse() * finals[i].pose;
    EXPECT_LT(std::abs(off.translation.y()), 0.03) << i;
    EXPECT_LT(std::abs(off.translation.z()), 0.03) << i;
    EXPECT_LT(so3_log(off.rotation).norm(), 0.01) << i;
    EXPECT_LT(std::abs(finals[i].pose.translation.x()), 1.6) << "it doesn't slide away";
  }
}

TEST(Odometry, InterpolatesTheRobotsOdometry) {
  OdometryParams params;
  params.source = "topic";
  Odometry odometry(params, {Eigen::Quaterniond::Identity(), {0.1, 0, 0.2}});
  const auto scan_at = [](double time) {
    auto cloud = std::make_shared<Cloud>();
    cloud->stamp = Stamp::from_seconds(time);
    cloud->points.resize(100);
    for (Point& point : cloud->points) point.x = 2;
    return cloud;
  };
  EXPECT_EQ(odometry.process(scan_at(0.1)).verdict, ScanVerdict::no_odometry);
  for (int i = 0; i <= 100; ++i) {
    const double time = 0.02 * i;
    odometry.add(OdometrySample{Stamp::from_seconds(time), {so3_exp({0, 0, 0.5 * time}), {time, 0, 0}}, Matrix6::Identity()});
  }
  const OdometryOutput output = odometry.process(scan_at(0.11));
  ASSERT_EQ(output.verdict, ScanVerdict::accepted);
  EXPECT_EQ(output.live.status, OdometryStatus::external);
  EXPECT_NEAR(output.live.T_odom_base.translation.x(), 0.11, 1e-3);
  EXPECT_NEAR(yaw_of(output.live.T_odom_base.rotation), 0.055, 1e-3);
  EXPECT_EQ(odometry.process(scan_at(5.0)).verdict, ScanVerdict::no_odometry);
}

// Wheels that slip by a tenth: the scans say how far it was.
TEST(Odometry, KeyframesOfWheelsCarryTheMotionThatTheirScansShow) {
  sim::Scene scene(test::box({-4, -3, 0}, {4, 3, 2.6}));
  OdometryParams params;
  params.source = "topic";
  Odometry odometry(params, {Eigen::Quaterniond::Identity(), {0, 0, 1.2}});
  constexpr double speed = 0.8;
  constexpr double slipping = 0.9;
  const Prefilter prefilter({});
  for (int i = 0; i <= 300; ++i) {
    const double time = 0.01 * i;
    odometry.add(OdometrySample{Stamp::from_seconds(time), {Eigen::Quaterniond::Identity(), {slipping * speed * time, 0, 0}}, Matrix6::Zero()});
  }
  std::vector<Keyframe> keyframes;
  std::vector<double> at;
  for (int i = 1; i < 29; ++i) {
    const double time = 0.1 * i;
    const Pose T_world_lidar{Eigen::Quaterniond::Identity(), {speed * time - 1, 0.3, 1.2}};
    Cloud scan = test::static_scan(scene, T_world_lidar, 0.02, static_cast<std::uint64_t>(i));
    for (Point& point : scan.points) point.time = 0;
    scan.stamp = Stamp::from_seconds(time);
    const OdometryOutput output = odometry.process(prefilter.process(scan).cloud);
    for (const Keyframe& keyframe : output.keyframes) {
      keyframes.push_back(keyframe);
      at.push_back(speed * time);
    }
  }
  ASSERT_GE(keyframes.size(), 3U);
  EXPECT_FALSE(keyframes[0].measured);
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    ASSERT_TRUE(keyframes[i].measured) << i;
    const double way = at[i] - at[i - 1];
    EXPECT_NEAR(keyframes[i].measured->T_last_now.translation.x(), way, 0.01) << "claimed " << slipping * way;
  }
}

}  // namespace
}  // namespace sgraph
