#include "sgraph_slam/core/io/seen_through.hpp"

#include <functional>

#include <gtest/gtest.h>

#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/io/occupancy_grid.hpp"
#include "small_room.hpp"

namespace sgraph {
namespace {

struct Column {
  Eigen::Vector2d at;  // in the room
  double radius;
  double height;
};

const Column visitor{{1.2, 0.4}, 0.25, 1.7};
const Column pole{{-1.5, 0.6}, 0.02, 2.5};

// What the LiDAR at (0, -1, 1) sees with columns in its way.
CloudPtr with(const Cloud& cloud, const std::vector<Column>& columns) {
  auto seen = std::make_shared<Cloud>(cloud);
  const Eigen::Vector3d eye(0, -1, 1);
  for (Point& point : seen->points) {
    for (const Column& column : columns) {
      const Eigen::Vector3d ray = point.position().cast<double>();
      const Eigen::Vector2d flat = ray.head<2>();
      const Eigen::Vector2d to = column.at - eye.head<2>();
      const double along = flat.dot(to) / flat.squaredNorm();  // of the nearest point, as a share of the ray
      const double beside = (to - along * flat).norm();
      if (!(along > 0 && beside < column.radius)) continue;  // false for NaN
      const double share = along - std::sqrt(column.radius * column.radius - beside * beside) / flat.norm();
      const double height = eye.z() + share * ray.z();
      if (share < 1 && height > 0 && height < column.height) point.set_position((share * ray).cast<float>());
    }
  }
  return seen;
}

// Keyframes at one place, each with its columns.
GraphSnapshot visits(const SmallRoom& room, const std::vector<std::vector<Column>>& columns) {
  GraphSnapshot snapshot = room.snapshot;
  const SceneKeyframe first = snapshot.keyframes.at({0});
  for (std::size_t k = 0; k < columns.size(); ++k) {
    SceneKeyframe& keyframe = snapshot.keyframes[{static_cast<std::int64_t>(k)}] = first;
    keyframe.id = {static_cast<std::int64_t>(k)};
    keyframe.cloud = with(*first.cloud.get(), columns[k]);
    snapshot.planes.at({0}).keyframes.insert(keyframe.id);
  }
  return snapshot;
}

int points_near(const Cloud& cloud, const Column& column, float low) {
  int count = 0;
  for (const Point& p : cloud.points)
    count += (p.position().head<2>().cast<double>() - column.at).norm() < column.radius + 0.05 && p.z > low && p.z < 2.4F;
  return count;
}

TEST(SeenThrough, WhoHasGoneIsNotInTheMapAndWhatIsThinStays) {
  const SmallRoom room;
  const std::vector<Column> both{visitor, pole};
  const std::vector<Column> alone{pole};
  const GraphSnapshot snapshot = visits(room, {both, both, alone, alone, alone});
  const SeenThrough gone(snapshot, room.T_base_lidar());
  const Cloud all = map_cloud(snapshot, room.T_base_lidar(), 0.05);
  const Cloud cleaned = map_cloud(snapshot, room.T_base_lidar(), 0.05, std::cref(gone));
  EXPECT_GT(points_near(all, visitor, 0.2F), 100);
  EXPECT_EQ(points_near(cleaned, visitor, 0.2F), 0);  // below are his soles: next to the floor
  EXPECT_GT(points_near(all, pole, 0.2F), 5);
  EXPECT_EQ(points_near(cleaned, pole, 0.2F), points_near(all, pole, 0.2F));
  // Nothing else is touched: walls, floor, ceiling, and what is behind the door.
  const auto removed = static_cast<int>(all.size() - cleaned.size());
  EXPECT_GE(removed, points_near(all, visitor, 0.2F));
  EXPECT_LE(removed, points_near(all, visitor, 0.02F));
  const OutputParams params;
  EXPECT_EQ(make_occupancy_grid(snapshot, room.T_base_lidar(), params, std::cref(gone)).at({1.2, 0.16}), OccupancyGrid::free);
}

using Visits = std::vector<std::vector<Column>>;

// Points that are left out of the map.
std::size_t left_out(const SmallRoom& room, const Visits& columns) {
  const GraphSnapshot snapshot = visits(room, columns);
  const SeenThrough gone(snapshot, room.T_base_lidar());
  return map_cloud(snapshot, room.T_base_lidar(), 0.05).size() - map_cloud(snapshot, room.T_base_lidar(), 0.05, std::cref(gone)).size();
}

TEST(SeenThrough, TheLastVisitCounts) {
  const SmallRoom room;
  const std::vector<Column> there{visitor};
  // One look isn't enough; what came and stays is there, also where nothing had been before; so is what came back.
  for (const Visits& columns : {Visits{there, {}}, Visits{{}, {}, {}, there, there, there}, Visits{there, {}, {}, {}, there, there, there}})
    EXPECT_EQ(left_out(room, columns), 0U) << columns.size();
}

TEST(SeenThrough, WhoIsSeenLastWhileHeWalksByIsGone) {
  const SmallRoom room;
  const std::vector<Column> there{visitor};
  EXPECT_GT(left_out(room, {{}, {}, there}), 100U);
  EXPECT_GT(left_out(room, {{}, {}, there, there}), 100U);
  // Nobody knows what was there before the first look.
  EXPECT_EQ(left_out(room, {there, there}), 0U);
  EXPECT_EQ(left_out(room, {{}, there, there}), 0U);
  // Where people come and go, one who waits is gone as well; something that stays isn't.
  EXPECT_GT(left_out(room, {there, {}, {}, there, {}, {}, there, there, there, there}), 100U);
  EXPECT_EQ(left_out(room, {there, {}, {}, there, {}, {}, there, there, there, there, there}), 0U);
}

// People who walk to and fro on one line make a wall of it, which must not hold them in the map.
TEST(SeenThrough, AWallOfPeopleIsNone) {
  const SmallRoom room;
  const std::vector<Column> there{visitor};
  GraphSnapshot snapshot = visits(room, {there, there, there, {}, {}, {}});
  ScenePlane plane = snapshot.planes.at({0});
  plane.id = {1000};
  const double front = visitor.at.y() - visitor.radius;
  plane.plane = Plane{Eigen::Vector3d(0, -1, 0), front};
  const double left = visitor.at.x() - visitor.radius, right = visitor.at.x() + visitor.radius;
  plane.extent = {{left, front, 0.3}, {right, front, 0.3}, {right, front, visitor.height}, {left, front, visitor.height}};
  snapshot.planes[plane.id] = plane;
  const SeenThrough gone(snapshot, room.T_base_lidar());
  EXPECT_TRUE(gone({visitor.at.x(), front, 1.0}));
}

TEST(SeenThrough, AwkwardMapsAreNoTrouble) {
  EXPECT_FALSE(SeenThrough({}, {})({0, 0, 0}));
  SmallRoom room;
  auto cloud = std::make_shared<Cloud>(*room.snapshot.keyframes.at({0}).cloud.get());
  cloud->points.push_back({1e30F, 1e30F, -1e30F});
  cloud->points.push_back({1e5F, 0, 0});
  room.snapshot.keyframes.at({0}).cloud = cloud;
  SceneKeyframe far = room.snapshot.keyframes.at({0});
  far.id = {1};
  far.T_map_base.translation += Eigen::Vector3d(3000, 3000, 0);
  room.snapshot.keyframes[{1}] = far;
  const SeenThrough gone(room.snapshot, room.T_base_lidar());
  EXPECT_GT(gone.cell(), 0.2);  // coarser, not more memory
  EXPECT_FALSE(gone({0, 0, 1e30}));
  EXPECT_FALSE(gone({NAN, 0, 0}));
}

}  // namespace
}  // namespace sgraph
