#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "sgraph_slam/core/localisation/localiser.hpp"
#include "sgraph_slam/core/mapping/back_end.hpp"
#include "support/mapped_building.hpp"
#include "support/mapping_run.hpp"

namespace sgraph {
namespace {

using Way = std::vector<Eigen::Vector2d>;

Way office_way() {
  return {{2, 2},     {7, 2},   {7, 4},   {4.5, 4.5}, {4.5, 6.8},  {13.5, 6.8}, {13.5, 4}, {17, 3}, {11, 2}, {13.5, 4}, {13.5, 6.8}, {14.5, 6.8},
          {14.5, 10}, {17, 12}, {10, 12}, {14.5, 9},  {14.5, 6.8}, {4.5, 6.8},  {4.5, 10}, {2, 12}, {6, 12}, {4.5, 9},  {4.5, 4},    {2, 2}};
}

// Rooms of one size along a corridor, a door each; the corridor has a niche at its far end.
MappedBuilding cells(int count) {
  MappedBuilding building;
  std::vector<Eigen::Vector2d> doors;
  for (int i = 0; i < count; ++i) {
    building.add_room(4.15 * i, 0, 4.15 * i + 4, 5, {{}, {}, {{1.5, 2.5}}, {}});
    doors.emplace_back(4.15 * i + 1.5, 4.15 * i + 2.5);
  }
  building.add_room(0, 5.15, 4.15 * count, 7.15, {doors, {}, {}, {}});
  return building;
}

Way cells_way(int count) {
  Way way;
  for (int i = 0; i < count; ++i) {
    const double x = 4.15 * i + 2;
    for (const Eigen::Vector2d& p : Way{{x, 6}, {x, 4}, {x - 1, 2}, {x + 1, 2}, {x, 4}, {x, 6}}) way.push_back(p);
  }
  return way;
}

struct Mapped {
  std::shared_ptr<const ReferenceMap> map;
  Pose T_world_map;
};

Mapped map_of(const MappedBuilding& building, const Way& way) {
  const auto walk = building.walk(way, 0.75, 0.4, {}, 3);
  BackEnd back_end({}, MappedBuilding::T_base_lidar());
  for (const SeenKeyframe& seen : walk) back_end.process(seen.keyframe, seen.segments);
  const GraphSnapshotPtr snapshot = back_end.optimize();
  return {std::make_shared<const ReferenceMap>(*snapshot, MappedBuilding::T_base_lidar()),
          walk.front().T_world_base * snapshot->keyframes.begin()->second.T_map_base.inverse()};
}

struct Answer {
  Localisation last;
  double error = 0;  // of the position when found [m]
  double angle = 0;  // [rad]
};

// The first answer `found`, or the last one.
Answer locate(const Mapped& mapped, const MappedBuilding& building, const Way& way, unsigned seed) {
  Localiser localiser(mapped.map, MappedBuilding::T_base_lidar());
  Answer answer;
  for (const SeenKeyframe& seen : building.walk(way, 0.5, -1.0, {}, seed)) {
    answer.last = localiser.add({seen.keyframe, seen.segments});
    if (std::getenv("SGRAPH_SHOW"))
      std::cout << answer.last.travelled << " m " << to_string(answer.last.result) << " " << answer.last.hypotheses << ": " << answer.last.reason
                << "; next " << answer.last.second.matched << " " << answer.last.second.unknown << " " << answer.last.second.contradicted << "; "
                << answer.last.milliseconds << " ms\n";
    if (answer.last.result != LocalisationResult::found) continue;
    const Pose error = (mapped.T_world_map * answer.last.T_map_base).inverse() * seen.T_world_base;
    answer.error = error.translation.norm();
    answer.angle = 2 * std::acos(std::min(1.0, std::abs(error.rotation.w())));
    break;
  }
  return answer;
}

TEST(Localiser, FindsItsPlaceInAnOffice) {
  const MappedBuilding building = office();
  const Mapped mapped = map_of(building, office_way());
  const std::vector<Way> ways{
      {{6, 3}, {2, 3}, {4.5, 4.5}, {4.5, 6.8}, {8, 6.8}}, {{16, 10}, {10, 10}, {14.5, 9}, {14.5, 6.8}}, {{10, 6.8}, {3, 6.8}, {4.5, 6.8}, {4.5, 10}}};
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const Answer answer = locate(mapped, building, ways[i], 20 + static_cast<unsigned>(i));
    EXPECT_EQ(answer.last.result, LocalisationResult::found) << i << ": " << answer.last.reason;
    EXPECT_LT(answer.error, 0.05) << i;
    EXPECT_LT(answer.angle, 0.01) << i;
    EXPECT_LT(answer.last.travelled, 5.1) << i;
  }
}

// Within one of eight equal rooms nothing tells which it is; the end of the corridor does.
TEST(Localiser, EqualRoomsAreAmbiguousUntilSomethingTellsThemApart) {
  const MappedBuilding building = cells(8);
  const Mapped mapped = map_of(building, cells_way(8));
  const double x = 4.15 * 2 + 2;
  const Answer inside = locate(mapped, building, {{x - 1, 2}, {x + 1, 2}, {x + 1, 3}, {x - 1, 3}}, 31);
  EXPECT_EQ(inside.last.result, LocalisationResult::ambiguous) << inside.last.reason;
  EXPECT_GE(inside.last.hypotheses, 6);
  const Answer outside = locate(mapped, building, {{x, 2}, {x, 4}, {x, 6}, {2, 6}}, 32);
  EXPECT_EQ(outside.last.result, LocalisationResult::found) << outside.last.reason;
  EXPECT_LT(outside.error, 0.05);
}

TEST(Localiser, AnotherBuildingIsNotInTheMap) {
  const Mapped mapped = map_of(office(), office_way());
  MappedBuilding other;
  other.add_room(0, 0, 7, 4.5, {{}, {}, {{3, 4}}, {}});
  other.add_room(0, 4.65, 16, 6.45, {{{3, 4}, {11, 12}}, {}, {}, {}});
  other.add_room(7.15, 0, 16, 4.5, {{}, {}, {{3.85, 4.85}}, {}});
  const Answer answer = locate(mapped, other, {{2, 2}, {6, 2}, {3.5, 3.5}, {3.5, 5.5}, {11.5, 5.5}, {11.5, 3}, {9, 2}, {14, 2}}, 41);
  EXPECT_EQ(answer.last.result, LocalisationResult::not_found) << answer.last.reason;
}

}  // namespace
}  // namespace sgraph
