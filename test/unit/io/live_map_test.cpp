#include <gtest/gtest.h>

#include <algorithm>

#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/io/occupancy_grid.hpp"
#include "small_room.hpp"

namespace sgraph {
namespace {

std::vector<Eigen::Vector3f> sorted_positions(const Cloud& cloud) {
  std::vector<Eigen::Vector3f> positions;
  for (const Point& p : cloud.points) positions.push_back(p.position());
  const auto cell = [](float value) { return std::lround(value / 0.1F - 0.5F); };
  std::sort(positions.begin(), positions.end(), [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return std::array{cell(a.x()), cell(a.y()), cell(a.z())} < std::array{cell(b.x()), cell(b.y()), cell(b.z())};
  });
  return positions;
}

// Keyframes come one by one, and the map moves under them: what is kept up is what would be made anew.
TEST(LiveMap, KeptUpIsTheSameAsMadeAnew) {
  const SmallRoom room;
  const OutputParams params;
  GraphSnapshot snapshot = room.snapshot;
  const SceneKeyframe first = snapshot.keyframes.at({0});
  LiveMapCloud cloud(0.1);
  LiveOccupancyGrid grid(params);
  for (std::int64_t k = 0; k < 6; ++k) {
    SceneKeyframe& keyframe = snapshot.keyframes[{k}] = first;
    keyframe.id = {k};
    keyframe.T_map_base.translation += Eigen::Vector3d(0.013 * static_cast<double>(k), 0.021 * static_cast<double>(k), 0);
    snapshot.planes.at({0}).keyframes.insert({k});
    if (k == 4) snapshot.keyframes.at({1}).T_map_base.translation.x() += 0.33;  // a loop was closed
    cloud.update(snapshot, room.T_base_lidar());
    grid.update(snapshot, room.T_base_lidar());
  }
  LiveMapCloud anew(0.1);
  anew.update(snapshot, room.T_base_lidar());
  const auto kept = sorted_positions(cloud.cloud());
  const auto made = sorted_positions(anew.cloud());
  EXPECT_EQ(made.size(), map_cloud(snapshot, room.T_base_lidar(), 0.1).size());
  ASSERT_EQ(kept.size(), made.size());
  for (std::size_t i = 0; i < made.size(); ++i) EXPECT_LT((kept[i] - made[i]).norm(), 1e-4F) << i;

  const OccupancyGrid all = make_occupancy_grid(snapshot, room.T_base_lidar(), params);
  const OccupancyGrid live = grid.grid();
  int known = 0;
  for (int y = 0; y < all.height; ++y) {
    for (int x = 0; x < all.width; ++x) {
      const Eigen::Vector2d p = all.origin + all.resolution * Eigen::Vector2d(x + 0.5, y + 0.5);
      known += all.at(p) != OccupancyGrid::unknown;
      EXPECT_EQ(live.at(p), all.at(p)) << p.transpose();
    }
  }
  EXPECT_GT(known, 5000);

  GraphSnapshot other;  // the map begins anew
  cloud.update(other, room.T_base_lidar());
  grid.update(other, room.T_base_lidar());
  EXPECT_TRUE(cloud.cloud().empty());
  EXPECT_TRUE(grid.grid().cells.empty());
}

}  // namespace
}  // namespace sgraph
