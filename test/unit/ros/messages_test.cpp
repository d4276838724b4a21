#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/ros/messages.hpp"

namespace sgraph {
namespace {

/// Seeded values with nothing round in them.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}

  double number() { return uniform_(engine_); }
  Eigen::Vector3d vector() { return {number(), number(), number()}; }
  Vector6 direction() {
    Vector6 v;
    for (int i = 0; i < 6; ++i) v[i] = number();
    return v.normalized();
  }
  template <int N>
  Eigen::Matrix<double, N, N> covariance() {
    Eigen::Matrix<double, N, N> a;
    for (int i = 0; i < N * N; ++i) a.data()[i] = number();
    return a * a.transpose();
  }
  Pose pose() {
    Vector6 xi;
    xi << vector(), 10 * vector();
    return se3_exp(xi);
  }
  std::vector<Eigen::Vector3d> polygon() { return {vector(), vector(), vector(), vector()}; }
  Plane plane() { return {vector().normalized(), 5 * number()}; }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

void expect_same(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
  EXPECT_EQ(a.translation, b.translation);
}

Keyframe random_keyframe(unsigned seed) {
  Draw draw(seed);
  Keyframe keyframe;
  keyframe.id = {seed};
  keyframe.stamp = {1'700'000'000'123'456'789 + static_cast<std::int64_t>(seed)};
  keyframe.T_odom_base = draw.pose();
  keyframe.covariance = draw.covariance<6>();
  if (seed % 2 == 0) keyframe.measured = KeyframeMotion{draw.pose(), draw.covariance<6>()};
  for (unsigned i = 0; i < seed % 3; ++i) keyframe.degenerate.push_back(draw.direction());
  for (unsigned i = 0; i <= seed % 7; ++i) keyframe.scans.push_back({{keyframe.stamp.nanoseconds - 100'000'001 * (seed % 7 - i)}, draw.pose()});
  return keyframe;
}

PlaneSegments random_segments(unsigned seed) {
  Draw draw(seed);
  PlaneSegments segments;
  segments.stamp = {1'700'000'000'999'999'999};
  for (unsigned i = 0; i < seed % 5; ++i) {
    PlaneSegment segment;
    segment.plane = draw.plane();
    segment.covariance = draw.covariance<3>();
    segment.scatter = draw.covariance<4>();
    segment.sigma = std::abs(draw.number());
    segment.count = static_cast<int>(100 + i);
    segment.centroid = draw.vector();
    segment.extent = draw.polygon();
    segments.segments.push_back(segment);
  }
  return segments;
}

TEST(Messages, KeyframeComesBack) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Keyframe sent = random_keyframe(seed);
    const Pose T_base_lidar = Draw(seed + 1000).pose();
    const auto message = to_message(sent, T_base_lidar, "odom", "base_link");
    EXPECT_EQ(message.header.frame_id, "odom");
    const auto received = from_message(message);
    ASSERT_TRUE(received);
    EXPECT_EQ(received->base_frame, "base_link");
    EXPECT_EQ(received->odom_frame, "odom");
    expect_same(received->T_base_lidar, T_base_lidar);
    const Keyframe& back = received->keyframe;
    EXPECT_EQ(back.id, sent.id);
    EXPECT_EQ(back.stamp, sent.stamp);
    expect_same(back.T_odom_base, sent.T_odom_base);
    EXPECT_EQ(back.covariance, sent.covariance);
    EXPECT_EQ(back.degenerate, sent.degenerate);
    ASSERT_EQ(back.measured.has_value(), sent.measured.has_value());
    if (sent.measured) {
      expect_same(back.measured->T_last_now, sent.measured->T_last_now);
      EXPECT_EQ(back.measured->covariance, sent.measured->covariance);
    }
    ASSERT_EQ(back.scans.size(), sent.scans.size());
    for (std::size_t i = 0; i < sent.scans.size(); ++i) {
      EXPECT_EQ(back.scans[i].stamp, sent.scans[i].stamp);
      expect_same(back.scans[i].pose, sent.scans[i].pose);
    }
  }
}

TEST(Messages, CovarianceIsRowByRowRotationFirst) {
  Keyframe keyframe = random_keyframe(0);
  keyframe.covariance = Matrix6::Identity();
  keyframe.covariance(0, 5) = keyframe.covariance(5, 0) = 0.25;  // rotation x, translation z
  const auto message = to_message(keyframe, {}, "odom", "base_link");
  EXPECT_EQ(message.covariance[5], 0.25);
  EXPECT_EQ(message.covariance[30], 0.25);
}

TEST(Messages, PlaneSegmentsComeBack) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const PlaneSegments sent = random_segments(seed);
    const auto back = from_message(to_message(sent, "velodyne"));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->stamp, sent.stamp);
    ASSERT_EQ(back->segments.size(), sent.segments.size());
    for (std::size_t i = 0; i < sent.segments.size(); ++i) {
      const PlaneSegment& a = back->segments[i];
      const PlaneSegment& b = sent.segments[i];
      EXPECT_EQ(a.plane.normal, b.plane.normal);
      EXPECT_EQ(a.plane.d, b.plane.d);
      EXPECT_EQ(a.covariance, b.covariance);
      EXPECT_EQ(a.scatter, b.scatter);
      EXPECT_EQ(a.sigma, b.sigma);
      EXPECT_EQ(a.count, b.count);
      EXPECT_EQ(a.centroid, b.centroid);
      EXPECT_EQ(a.extent, b.extent);
    }
  }
}

GraphSnapshot random_snapshot(unsigned seed) {
  Draw draw(seed);
  GraphSnapshot snapshot;
  snapshot.version = seed;
  snapshot.frame = "map";
  snapshot.T_map_odom = draw.pose();
  snapshot.dominant_yaw = draw.number();
  for (std::int64_t i = 0; i < 5; ++i) {
    SceneKeyframe keyframe{{i}, {1'600'000'000'000'000'001 + i}, draw.pose(), draw.pose(), {}, nullptr};
    snapshot.keyframes.insert({keyframe.id, keyframe});
    ScenePlane plane{{2 * i}, draw.plane(), static_cast<PlaneClass>(i % 4), draw.covariance<3>(), draw.polygon(), {{i}, {i + 3}}};
    snapshot.planes.insert({plane.id, plane});
  }
  snapshot.rooms.insert({{3}, {{3}, draw.vector(), {4.5, 6.25}, draw.number(), {{0}, {2}, {4}, {6}}}});
  snapshot.corridors.insert({{1}, {{1}, draw.vector(), 1.9, draw.number(), 12.5, {{8}, {2}}}});
  snapshot.openings.push_back({"room/3", "corridor/1", draw.vector()});
  SceneRoom hall;
  hall.id = {5};
  hall.center = draw.vector();
  hall.planes = {{0}, {2}};
  hall.polygon = {{0, 0}, {4, draw.number()}, {3, 5}};
  hall.edges = {{SceneSide::Kind::wall, {2}, {}}, {SceneSide::Kind::door, {}, {7}}, {SceneSide::Kind::opening, {}, {}}};
  hall.storey = 2;
  hall.holes = {{{1, 1}, {1, 2}, {2, 2}}};
  SceneBranching branching;
  branching.parts = {{1}, {4}};
  branching.polygon = hall.polygon;
  branching.edges = hall.edges;
  branching.storey = 2;
  branching.holes = hall.holes;
  snapshot.branchings.push_back(branching);
  snapshot.rooms.insert({hall.id, hall});
  snapshot.doors.insert({{7}, {{7}, "room/3", "room/5", draw.vector(), draw.number(), 0.95, 2.1, 2}});
  snapshot.storeys.push_back({2, draw.number(), draw.number(), true});
  return snapshot;
}

void expect_same_places(const GraphSnapshot& a, const GraphSnapshot& b) {
  const SceneRoom& room = a.rooms.at({3});
  EXPECT_EQ(room.center, b.rooms.at({3}).center);
  EXPECT_EQ(room.width, b.rooms.at({3}).width);
  EXPECT_EQ(room.yaw, b.rooms.at({3}).yaw);
  EXPECT_EQ(room.planes, b.rooms.at({3}).planes);
  const SceneCorridor& corridor = a.corridors.at({1});
  EXPECT_EQ(corridor.center, b.corridors.at({1}).center);
  EXPECT_EQ(corridor.width, b.corridors.at({1}).width);
  EXPECT_EQ(corridor.yaw, b.corridors.at({1}).yaw);
  EXPECT_EQ(corridor.length, b.corridors.at({1}).length);
  EXPECT_EQ(corridor.planes, b.corridors.at({1}).planes);
  const SceneRoom& hall = a.rooms.at({5});
  EXPECT_FALSE(b.rooms.at({5}).is_rectangle());
  EXPECT_EQ(hall.polygon, b.rooms.at({5}).polygon);
  EXPECT_EQ(hall.storey, b.rooms.at({5}).storey);
  EXPECT_EQ(hall.holes, b.rooms.at({5}).holes);
  ASSERT_EQ(b.branchings.size(), 1U);
  EXPECT_EQ(a.branchings[0].parts, b.branchings[0].parts);
  EXPECT_EQ(a.branchings[0].polygon, b.branchings[0].polygon);
  EXPECT_EQ(a.branchings[0].edges.size(), b.branchings[0].edges.size());
  EXPECT_EQ(a.branchings[0].storey, b.branchings[0].storey);
  EXPECT_EQ(a.branchings[0].holes, b.branchings[0].holes);
  ASSERT_EQ(hall.edges.size(), b.rooms.at({5}).edges.size());
  for (std::size_t i = 0; i < hall.edges.size(); ++i) {
    EXPECT_EQ(hall.edges[i].kind, b.rooms.at({5}).edges[i].kind);
    EXPECT_EQ(hall.edges[i].plane, b.rooms.at({5}).edges[i].plane);
    EXPECT_EQ(hall.edges[i].door, b.rooms.at({5}).edges[i].door);
  }
  const SceneDoor& door = a.doors.at({7});
  EXPECT_EQ(door.from, b.doors.at({7}).from);
  EXPECT_EQ(door.to, b.doors.at({7}).to);
  EXPECT_EQ(door.position, b.doors.at({7}).position);
  EXPECT_EQ(door.yaw, b.doors.at({7}).yaw);
  EXPECT_EQ(door.width, b.doors.at({7}).width);
  EXPECT_EQ(door.height, b.doors.at({7}).height);
  ASSERT_EQ(b.storeys.size(), 1U);
  EXPECT_EQ(a.storeys[0].z, b.storeys[0].z);
  EXPECT_TRUE(b.storeys[0].height_known);
  ASSERT_EQ(a.openings.size(), b.openings.size());
  EXPECT_EQ(a.openings[0].from, b.openings[0].from);
  EXPECT_EQ(a.openings[0].to, b.openings[0].to);
  EXPECT_EQ(a.openings[0].position, b.openings[0].position);
}

TEST(Messages, GraphComesBack) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const GraphSnapshot sent = random_snapshot(seed);
    const auto message = to_message(sent);
    EXPECT_EQ(message.header.stamp, ros::Time(1'600'000'000, 5));  // the newest keyframe's
    const auto back = from_message(message);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->version, sent.version);
    EXPECT_EQ(back->frame, "map");
    expect_same(back->T_map_odom, sent.T_map_odom);
    EXPECT_EQ(back->dominant_yaw, sent.dominant_yaw);
    ASSERT_EQ(back->keyframes.size(), sent.keyframes.size());
    for (const auto& [id, keyframe] : sent.keyframes) {
      EXPECT_EQ(back->keyframes.at(id).stamp, keyframe.stamp);
      expect_same(back->keyframes.at(id).T_map_base, keyframe.T_map_base);
      expect_same(back->keyframes.at(id).T_odom_base, keyframe.T_odom_base);
    }
    ASSERT_EQ(back->planes.size(), sent.planes.size());
    for (const auto& [id, plane] : sent.planes) {
      const ScenePlane& other = back->planes.at(id);
      EXPECT_EQ(other.plane.normal, plane.plane.normal);
      EXPECT_EQ(other.plane.d, plane.plane.d);
      EXPECT_EQ(other.plane_class, plane.plane_class);
      EXPECT_EQ(other.covariance, plane.covariance);
      EXPECT_EQ(other.extent, plane.extent);
      EXPECT_EQ(other.keyframes, plane.keyframes);
    }
    expect_same_places(*back, sent);
  }
}

TEST(Messages, RefusesWhatIsNotANumberOrNotAUnit) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto keyframe = to_message(random_keyframe(5), {}, "odom", "base_link");
  auto bad = keyframe;
  bad.pose.position.x = nan;
  EXPECT_FALSE(from_message(bad));
  bad = keyframe;
  bad.pose.orientation = geometry_msgs::Quaternion();  // all zero, as a message that nobody filled in
  EXPECT_FALSE(from_message(bad));
  bad = keyframe;
  bad.covariance[7] = -1;
  EXPECT_FALSE(from_message(bad));
  bad = keyframe;
  bad.scans[0].pose.orientation.w = nan;
  EXPECT_FALSE(from_message(bad));
  bad = keyframe;
  bad.id = -1;
  EXPECT_FALSE(from_message(bad));

  auto planes = to_message(random_segments(4), "velodyne");
  planes.segments[1].normal.x += 0.5;
  EXPECT_FALSE(from_message(planes));
  planes = to_message(random_segments(4), "velodyne");
  planes.segments[1].extent[2].z = nan;
  EXPECT_FALSE(from_message(planes));

  auto graph = to_message(random_snapshot(1));
  graph.planes[0].plane_class = 9;
  EXPECT_FALSE(from_message(graph));
  graph = to_message(random_snapshot(1));
  graph.rooms[0].planes.pop_back();
  EXPECT_FALSE(from_message(graph));
}

TEST(Messages, StatusComesBack) {
  Draw draw(3);
  for (const OdometryStatus status : {OdometryStatus::started, OdometryStatus::tracked, OdometryStatus::predicted, OdometryStatus::external}) {
    OdometryEstimate sent;
    sent.stamp = {1'700'000'000'000'000'007};
    sent.status = status;
    sent.inlier_share = draw.number();
    sent.residual_rms = draw.number();
    sent.keypoints = 1234;
    sent.iterations = 5;
    sent.degenerate = {draw.direction(), draw.direction()};
    const auto back = from_message(to_status_message(ScanVerdict::accepted, sent, "odom"));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->stamp, sent.stamp);
    EXPECT_EQ(back->status, status);
    EXPECT_EQ(back->inlier_share, sent.inlier_share);
    EXPECT_EQ(back->residual_rms, sent.residual_rms);
    EXPECT_EQ(back->keypoints, 1234);
    EXPECT_EQ(back->iterations, 5);
    EXPECT_EQ(back->degenerate, sent.degenerate);
  }
}

TEST(Messages, StatusOfARefusedScanSaysWhy) {
  const auto message = to_status_message(ScanVerdict::too_few_points, {}, "odom");
  EXPECT_FALSE(message.accepted);
  EXPECT_EQ(message.verdict, to_string(ScanVerdict::too_few_points));
  EXPECT_FALSE(from_message(message));
}

TEST(Messages, OdometryCovarianceIsAboutTheFixedAxes) {
  OdometryEstimate estimate;
  estimate.T_odom_base = {Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())), {1, 2, 3}};  // base x is odom y
  Vector6 variances;
  variances << 1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03;
  estimate.covariance = variances.asDiagonal();
  estimate.twist << 0.1, 0.2, 0.3, 1, 2, 3;
  const nav_msgs::Odometry message = to_odometry_message(estimate, "odom", "base_link");
  EXPECT_EQ(message.header.frame_id, "odom");
  EXPECT_EQ(message.child_frame_id, "base_link");
  EXPECT_NEAR(message.pose.covariance[0], 0.02, 1e-12);   // along odom x: base y
  EXPECT_NEAR(message.pose.covariance[7], 0.01, 1e-12);   // along odom y: base x
  EXPECT_NEAR(message.pose.covariance[14], 0.03, 1e-12);  // along z
  EXPECT_NEAR(message.pose.covariance[21], 2e-4, 1e-12);  // about odom x: base y
  EXPECT_NEAR(message.pose.covariance[28], 1e-4, 1e-12);  // about odom y
  EXPECT_NEAR(message.pose.covariance[35], 3e-4, 1e-12);  // about z
  EXPECT_EQ(message.twist.twist.linear.x, 1);
  EXPECT_EQ(message.twist.twist.angular.z, 0.3);
}

/// The covariance that the message states is that of samples of the pose, in the message's sense: position, and small rotations about fixed axes.
TEST(Messages, OdometryCovarianceAgreesWithSamples) {
  Draw draw(11);
  OdometryEstimate estimate;
  estimate.T_odom_base = draw.pose();
  estimate.covariance = 1e-6 * draw.covariance<6>();
  const Matrix6 root = estimate.covariance.llt().matrixL();
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  Matrix6 sum = Matrix6::Zero();
  const int samples = 20000;
  for (int i = 0; i < samples; ++i) {
    Vector6 z;
    for (int k = 0; k < 6; ++k) z[k] = normal(engine);
    const Pose sample = estimate.T_odom_base * se3_exp(root * z);
    const Eigen::AngleAxisd turn(sample.rotation * estimate.T_odom_base.rotation.conjugate());
    Vector6 difference;
    difference << sample.translation - estimate.T_odom_base.translation, turn.angle() * turn.axis();
    sum += difference * difference.transpose() / samples;
  }
  const nav_msgs::Odometry message = to_odometry_message(estimate, "odom", "base_link");
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column)
      EXPECT_NEAR(message.pose.covariance[static_cast<std::size_t>(6 * row + column)], sum(row, column),
                  0.05 * std::sqrt(sum(row, row) * sum(column, column)));
}

}  // namespace
}  // namespace sgraph
