#include "sgraph_slam/core/io/mirror_images.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "sgraph_slam/core/io/map_cloud.hpp"

namespace sgraph {
namespace {

using Eigen::Vector3d;

// A room of 6 x 4 x 2.5 m about the origin with a door in its wall at x = 3 to a room like it, and a window in its wall at y = 2.
const Vector3d low(-3, -2, 0);
const Vector3d high(3, 2, 2.5);
constexpr double door_depth = 0.1;
constexpr double pane = 2.1;  // y

bool in_window(const Vector3d& p) { return std::abs(p.x()) < 0.7 && p.z() > 0.9 && p.z() < 2.0; }
bool in_door(const Vector3d& p) { return std::abs(p.y()) < 0.5 && p.z() < 2.0; }

// Where a ray from within the box leaves it.
double leaves(const Vector3d& eye, const Vector3d& direction, const Vector3d& least, const Vector3d& most) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    if (std::abs(direction[k]) < 1e-9) continue;
    nearest = std::min(nearest, ((direction[k] > 0 ? most[k] : least[k]) - eye[k]) / direction[k]);
  }
  return nearest;
}

// Behind the window there is a yard, or a room 6 m deep with a shelf right where the mirrored wall would be. Glass that glimmers shows the room, and
// to a quarter of the rays what stands before it; where it flickers, more rays end anywhere between the pane and the room's end.
enum class Window { mirrors, shows_the_yard, shows_a_room, glimmers, flickers };

constexpr double room_end = 8.2;        // y
constexpr double shelf = 2 * pane + 2;  // y: the image of the wall at y = -2
bool in_shelf(const Vector3d& p) { return p.x() > 0.2 && p.x() < 1.2 && p.z() < 1.8; }

// Range that the LiDAR reports along a ray.
double range(const Vector3d& eye, const Vector3d& direction, Window window) {
  const double first = leaves(eye, direction, low, high);
  const Vector3d at = eye + first * direction;
  if (at.x() > high.x() - 1e-6 && in_door(at)) {
    const Vector3d shift(6 + door_depth, 0, 0);
    const double through = (high.x() + door_depth + 1e-6 - eye.x()) / direction.x();
    const Vector3d entered = eye + through * direction;
    return in_door(entered) ? through + leaves(entered, direction, low + shift, high + shift) : first;
  }
  if (at.y() > high.y() - 1e-6 && in_window(at)) {
    const double to_pane = (pane - eye.y()) / direction.y();
    if (std::abs(direction.y()) > (window == Window::flickers ? 0.97 : 0.99)) return to_pane;  // head-on
    if (window == Window::shows_the_yard) return direction.z() < -0.05 ? (-1 - eye.z()) / direction.z() : to_pane + 7 / direction.y();
    const int slot = static_cast<int>(40 * std::atan2(direction.x(), direction.y()) + 100) % 4;
    if (window == Window::flickers && (slot == 1 || (slot == 2 && direction.z() > 0))) {
      const double share = 0.5 + 0.5 * std::sin(1e4 * direction.x() + 3e4 * direction.z());
      return (pane + 0.2 + share * (room_end - pane - 0.6) - eye.y()) / direction.y();
    }
    if (window == Window::shows_a_room || (window != Window::mirrors && slot != 0)) {
      const double to_shelf = (shelf - eye.y()) / direction.y();
      if (in_shelf(eye + to_shelf * direction)) return to_shelf;
      const Vector3d entered = eye + (to_pane + 1e-6) * direction;
      return to_pane + 1e-6 + leaves(entered, direction, {-3, pane, 0}, {3, room_end, 2.5});
    }
    const Vector3d mirrored(direction.x(), -direction.y(), direction.z());
    const Vector3d on_pane = eye + to_pane * direction;
    const Vector3d back = on_pane + (on_pane.y() - high.y() + 1e-6) / direction.y() * mirrored;
    return to_pane + (on_pane - back).norm() + leaves(back, mirrored, low, high);
  }
  return first;
}

CloudPtr scan(const Vector3d& eye, Window window) {
  auto cloud = std::make_shared<Cloud>();
  for (int ring = -25; ring <= 25; ++ring) {
    for (int step = 0; step < 720; ++step) {
      const double azimuth = step * M_PI / 360;
      const double elevation = 0.016 * ring;
      const Vector3d direction(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      Point point;
      point.set_position((range(eye, direction, window) * direction).cast<float>());
      cloud->points.push_back(point);
    }
  }
  return cloud;
}

void add_plane(GraphSnapshot& snapshot, const Vector3d& normal, double d, const std::vector<Vector3d>& corners) {
  ScenePlane plane;
  plane.id = {static_cast<std::int64_t>(snapshot.planes.size())};
  plane.plane = {normal, d};
  plane.plane_class = std::abs(normal.z()) > 0.5 ? PlaneClass::horizontal : PlaneClass::x;
  plane.extent = corners;
  for (const auto& [id, keyframe] : snapshot.keyframes) plane.keyframes.insert(id);
  snapshot.planes[plane.id] = plane;
}

GraphSnapshot seen(Window window) {
  GraphSnapshot snapshot;
  for (const Vector3d& eye : {Vector3d(-1.5, -1, 1), Vector3d(0.5, -0.8, 1), Vector3d(1.0, 0.6, 1), Vector3d(-1.2, 0.9, 1)}) {
    SceneKeyframe keyframe;
    keyframe.id = {static_cast<std::int64_t>(snapshot.keyframes.size())};
    keyframe.T_map_base = {Eigen::Quaterniond::Identity(), eye};
    keyframe.cloud = scan(eye, window);
    snapshot.keyframes[keyframe.id] = keyframe;
  }
  add_plane(snapshot, {0, 0, 1}, 0, {{-3, -2, 0}, {3, -2, 0}, {3, 2, 0}, {-3, 2, 0}});
  add_plane(snapshot, {0, 0, -1}, 2.5, {{-3, 2, 2.5}, {3, 2, 2.5}, {3, -2, 2.5}, {-3, -2, 2.5}});
  add_plane(snapshot, {0, 1, 0}, 2, {{-3, -2, 0}, {3, -2, 0}, {3, -2, 2.5}, {-3, -2, 2.5}});
  add_plane(snapshot, {0, -1, 0}, 2, {{3, 2, 0}, {-3, 2, 0}, {-3, 2, 2.2}, {3, 2, 2.2}});
  add_plane(snapshot, {-1, 0, 0}, 3, {{3, -2, 0}, {3, 2, 0}, {3, 2, 2.2}, {3, -2, 2.2}});
  return snapshot;
}

int count(const Cloud& cloud, const std::function<bool(const Vector3d&)>& which) {
  int n = 0;
  for (const Point& point : cloud.points) n += which(point.position().cast<double>());
  return n;
}

TEST(MirrorImages, TheRoomBehindAWindowIsNotInTheMap) {
  const GraphSnapshot snapshot = seen(Window::mirrors);
  const MirrorImages images(snapshot, {});
  EXPECT_GE(images.holes(), 1);
  const Cloud all = map_cloud(snapshot, {}, 0);
  const Cloud cleaned = map_cloud(snapshot, {}, 0, std::cref(images));
  const auto behind_the_window = [](const Vector3d& p) { return p.y() > pane + 0.2 && std::abs(p.x()) < 3; };
  EXPECT_GT(count(all, behind_the_window), 1000);
  EXPECT_EQ(count(cleaned, behind_the_window), 0);
  // All else stays, the pane too, and the room behind the door, which nobody entered and which looks like the one before it.
  const auto elsewhere = [](const Vector3d& p) { return p.y() < pane + 0.1; };
  EXPECT_EQ(count(cleaned, elsewhere), count(all, elsewhere));
  EXPECT_GT(count(cleaned, [](const Vector3d& p) { return p.x() > 3.2; }), 500);
  EXPECT_GT(count(cleaned, [](const Vector3d& p) { return std::abs(p.y() - pane) < 0.01; }), 10);
}

TEST(MirrorImages, WhatIsThereBehindAWindowStays) {
  const GraphSnapshot snapshot = seen(Window::shows_the_yard);
  const MirrorImages images(snapshot, {});
  EXPECT_EQ(images.holes(), 0);
  EXPECT_EQ(map_cloud(snapshot, {}, 0, std::cref(images)).size(), map_cloud(snapshot, {}, 0).size());
}

TEST(MirrorImages, ImagesInGlassThatShowsARoomAreNotInTheMap) {
  const GraphSnapshot snapshot = seen(Window::glimmers);
  const MirrorImages images(snapshot, {});
  const Cloud all = map_cloud(snapshot, {}, 0);
  const Cloud cleaned = map_cloud(snapshot, {}, 0, std::cref(images));
  const auto mirrored_wall = [](const Vector3d& p) { return std::abs(p.y() - shelf) < 0.01 && p.z() > 0.15 && p.z() < 2.35 && !in_shelf(p); };
  EXPECT_GT(count(all, mirrored_wall), 300);
  EXPECT_LT(count(cleaned, mirrored_wall), 0.25 * count(all, mirrored_wall));
  // The room behind the glass stays, and the shelf in it.
  const auto room = [](const Vector3d& p) { return p.y() > pane && std::abs(p.y() - shelf) > 0.15; };
  EXPECT_GT(count(all, room), 1000);
  EXPECT_EQ(count(cleaned, room), count(all, room));
  const auto on_shelf = [](const Vector3d& p) { return std::abs(p.y() - shelf) < 0.01 && in_shelf(p); };
  EXPECT_GT(count(all, on_shelf), 50);
  EXPECT_GT(count(cleaned, on_shelf), 0.8 * count(all, on_shelf));
}

// Where the pane itself was seen, fewer of what rays pass need to be images.
TEST(MirrorImages, ImagesAmongPointsThatFloatBehindGlassAreNotInTheMap) {
  const GraphSnapshot snapshot = seen(Window::flickers);
  const Cloud all = map_cloud(snapshot, {}, 0);
  const MirrorImages images(snapshot, {});
  const Cloud cleaned = map_cloud(snapshot, {}, 0, std::cref(images));
  const auto mirrored_wall = [](const Vector3d& p) { return std::abs(p.y() - shelf) < 0.01 && p.z() > 0.15 && p.z() < 2.35 && !in_shelf(p); };
  EXPECT_GT(count(all, mirrored_wall), 300);
  EXPECT_LT(count(cleaned, mirrored_wall), 0.6 * count(all, mirrored_wall));
  const auto end_of_room = [](const Vector3d& p) { return std::abs(p.y() - room_end) < 0.01; };
  EXPECT_GT(count(all, end_of_room), 100);
  EXPECT_EQ(count(cleaned, end_of_room), count(all, end_of_room));
}

TEST(MirrorImages, TheRoomBehindGlassStays) {
  const GraphSnapshot snapshot = seen(Window::shows_a_room);
  const MirrorImages images(snapshot, {});
  EXPECT_EQ(map_cloud(snapshot, {}, 0, std::cref(images)).size(), map_cloud(snapshot, {}, 0).size());
}

// Nobody was near the window: its sill is told by the floor where the sensor was.
TEST(MirrorImages, AWindowFarAwayIsNoDoor) {
  GraphSnapshot snapshot = seen(Window::mirrors);
  constexpr double scale = 4;
  for (auto& [id, keyframe] : snapshot.keyframes) {
    auto cloud = std::make_shared<Cloud>(*keyframe.cloud.get());
    for (Point& point : cloud->points) point.set_position((scale * point.position()).eval());
    keyframe.cloud = cloud;
    keyframe.T_map_base.translation *= scale;
  }
  for (auto& [id, plane] : snapshot.planes) {
    plane.plane.d *= scale;
    for (Vector3d& corner : plane.extent) corner *= scale;
  }
  EXPECT_GE(MirrorImages(snapshot, {}).holes(), 1);
}

TEST(MirrorImages, AwkwardMapsAreNoTrouble) {
  const MirrorImages nothing({}, {});
  EXPECT_FALSE(nothing({0, 0, 0}));
  EXPECT_FALSE(nothing({NAN, 0, 0}));
  EXPECT_FALSE(nothing({0, 0, 1e30}));
  GraphSnapshot snapshot = seen(Window::mirrors);
  auto cloud = std::make_shared<Cloud>(*snapshot.keyframes.at({0}).cloud.get());
  cloud->points.push_back({NAN, 0, 0});
  cloud->points.push_back({1e30F, -1e30F, 1e30F});
  snapshot.keyframes.at({0}).cloud = cloud;
  add_plane(snapshot, {0, 1, 0}, 2, {{1e6, -2, 0}, {-1e6, -2, 0}, {-1e6, -2, 1e6}, {1e6, -2, 1e6}});
  EXPECT_GE(MirrorImages(snapshot, {}).holes(), 1);
}

}  // namespace
}  // namespace sgraph
