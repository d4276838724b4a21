// The back end as a back end: odometry with drift, several buildings, each mechanism on and off. It improves where it can, and does no harm.

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>

#include "support/mapping_run.hpp"

namespace sgraph {
namespace {

struct Building {
  std::string name;
  MappedBuilding walls;
  std::vector<Eigen::Vector2d> walk;
};

Building four_rooms() { return {"four rooms", office(), office_walk()}; }

// A corridor all round a block, twice.
Building ring() {
  MappedBuilding building;
  building.add_room(0, 0, 20, 14, {{}, {}, {}, {}});
  building.add_face({2.2, 2}, {2.2, 12});
  building.add_face({2.2, 12}, {17.8, 12});
  building.add_face({17.8, 12}, {17.8, 2});
  building.add_face({17.8, 2}, {2.2, 2});
  std::vector<Eigen::Vector2d> walk;
  for (int lap = 0; lap < 2; ++lap) {
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(1, 1), {19, 1}, {19, 13}, {1, 13}}) walk.push_back(corner);
  }
  walk.emplace_back(1, 1);
  return {"ring", building, walk};
}

// Two rooms with no wall parallel to the others', so that nothing of the building's axes helps, and a passage between.
Building oblique() {
  MappedBuilding building;
  const std::vector<Eigen::Vector2d> left{{0, 0}, {6, -0.6}, {6.4, 2}, {6.4, 3.2}, {6.1, 6}, {0.5, 5}};
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (i != 2) building.add_face(left[i], left[(i + 1) % left.size()]);
  }
  const std::vector<Eigen::Vector2d> right{{6.5, 2}, {7, -1}, {13, 0.4}, {12.2, 6.3}, {6.8, 6.5}, {6.5, 3.2}};
  for (std::size_t i = 0; i + 1 < right.size(); ++i) building.add_face(right[i], right[i + 1]);
  return {"oblique", building, {{1, 1}, {5, 1}, {5, 2.6}, {8, 2.6}, {11.5, 1.5}, {11, 5}, {8, 5}, {8, 2.6}, {5, 2.6}, {3, 4}, {1, 1}, {4, 2}}};
}

// Rooms alike to the last centimetre in a row along a corridor.
Building alike() {
  std::vector<Eigen::Vector2d> doors;
  for (int i = 0; i < 4; ++i) doors.emplace_back(4.15 * i + 1.5, 4.15 * i + 2.5);
  MappedBuilding building;
  building.add_face({0, 0}, {16.45, 0});
  building.add_face({16.45, 0}, {16.45, 2});
  std::vector<Eigen::Vector2d> backwards;
  for (auto door = doors.rbegin(); door != doors.rend(); ++door) backwards.emplace_back(16.45 - door->y(), 16.45 - door->x());
  building.add_face({16.45, 2}, {0, 2}, backwards);
  building.add_face({0, 2}, {0, 0});
  std::vector<Eigen::Vector2d> walk{{1, 1}};
  for (int i = 0; i < 4; ++i) {
    const double x = 4.15 * i;
    building.add_room(x, 2.15, x + 4, 6.5, {{{1.5, 2.5}}, {}, {}, {}});
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(x + 2, 1), {x + 2, 3}, {x + 3, 5}, {x + 1, 5}, {x + 2, 3}, {x + 2, 1}}) walk.push_back(p);
  }
  walk.emplace_back(1, 1);
  return {"rooms alike", building, walk};
}

struct Drift {
  std::string name;
  double scale;    // of the way
  double heading;  // [rad/m]
};

BuildingNoise noise_of(const Drift& drift) {
  BuildingNoise noise;
  noise.odometry_scale = drift.scale;
  noise.odometry_heading = drift.heading;
  return noise;
}

void show(const std::string& text) {
  if (std::getenv("SGRAPH_SHOW_TABLE")) std::cout << text << std::endl;
}

// What remains of the odometry's error, and what may at most remain: about three times what was
// measured.
TEST(Drift, TheGraphTakesItOutOfEveryBuilding) {
  const std::vector<Drift> drifts{{"none", 0, 0}, {"scale", 0.01, 0}, {"heading", 0, 0.004}, {"both", -0.02, -0.006}};
  for (const Building& building : {four_rooms(), ring(), oblique(), alike()}) {
    for (const Drift& drift : drifts) {
      const auto walk = building.walls.walk(building.walk, 0.8, 0.2, noise_of(drift), 11);
      const Outcome result = map_walk(walk, {});
      show(building.name + ", drift " + drift.name + ": " + std::to_string(result.odometry_ate) + " -> " + std::to_string(result.ate));
      const std::string what = building.name + ", drift " + drift.name;
      EXPECT_LT(result.ate, 0.010) << what;
      EXPECT_LT(result.ate, result.odometry_ate) << what;  // also without drift: never worse than what came in
    }
  }
}

struct Mechanism {
  std::string name;
  std::function<void(MappingParams&, bool)> set;
  double gain;  // how much worse it may at most get by it: the error with it over the error without
};

const std::vector<Mechanism>& mechanisms() {
  static const std::vector<Mechanism> all{
      {"topological layer", [](MappingParams& p, bool on) { p.topological_layer = on; }, 1.3},
      {"parallel walls", [](MappingParams& p, bool on) { p.topology.parallel_factors = on; }, 1.3},
      {"perpendicular walls", [](MappingParams& p, bool on) { p.topology.perpendicular_factors = on; }, 1.3},
      {"widths", [](MappingParams& p, bool on) { p.topology.width_factors = on; }, 1.5},
      {"thickness", [](MappingParams& p, bool on) { p.topology.thickness_factors = on; }, 1.5},
      {"merging", [](MappingParams& p, bool on) { p.merging.enabled = on; }, 1.3},
      {"merging by places", [](MappingParams& p, bool on) { p.merging.by_places = on; }, 1.3},
      {"dominant frame", [](MappingParams& p, bool on) { p.semantics.dominant_frame = on; }, 1.3},
      {"points form", [](MappingParams& p, bool on) { p.factors.plane_factor = on ? "points" : "tangent"; }, 1.5},
      {"loops", [](MappingParams& p, bool on) { p.loops.enabled = on; }, 1.3},
      {"window", [](MappingParams& p, bool on) { p.solving.window = on ? 8 : 0; }, 1.3},
  };
  return all;
}

TEST(Drift, NoMechanismDoesHarmInABuildingItIsMadeForOrNot) {
  for (const Building& building : {four_rooms(), oblique()}) {
    BuildingNoise noise = noise_of({"both", 0.015, 0.005});
    const auto walk = building.walls.walk(building.walk, 1.0, 0.2, noise, 12);
    for (const Mechanism& mechanism : mechanisms()) {
      MappingParams with;
      MappingParams without;
      mechanism.set(with, true);
      mechanism.set(without, false);
      const double ate_with = map_walk(walk, with).ate;
      const double ate_without = map_walk(walk, without).ate;
      show(building.name + ", " + mechanism.name + ": without " + std::to_string(ate_without) + ", with " + std::to_string(ate_with));
      EXPECT_LT(ate_with, mechanism.gain * ate_without + 0.001) << building.name << ", " << mechanism.name;
    }
  }
}

// Rooms that can't be told apart by their shapes stay as many as they are, also when the drift is nearly as large as a wall is thick.
TEST(Drift, RoomsAlikeAreNotTakenForEachOther) {
  const Building building = alike();
  for (const double heading : {0.0, 0.004, -0.008}) {
    const auto walk = building.walls.walk(building.walk, 0.8, 0.2, noise_of({"", 0.01, heading}), 13);
    const Outcome result = map_walk(walk, {});
    EXPECT_EQ(result.snapshot->rooms.size(), 4U) << heading;
    EXPECT_LT(result.ate, 0.03) << heading;
  }
}

// Two walls 4 cm off each other's line, each seen from its own side of a partition. A gate that is far too wide merges them: the views tell, the
// merge is undone, and not tried again.
TEST(Merges, ThatDoNotFitAreUndone) {
  MappedBuilding building;
  building.add_room(0, 0, 5, 4, {{}, {{1.5, 2.5}}, {}, {}});
  building.add_room(5.15, -0.05, 10, 4, {{}, {}, {}, {{1.5, 2.5}}});
  const auto walk = building.walk({{1, 1}, {4, 1}, {4, 2}, {9, 2}, {9, 1}, {6.5, 1}, {6.5, 2}, {3, 2}, {3, 3}, {1, 1}, {4, 1}}, 0.5, 0.1, {}, 4);
  const Outcome usual = map_walk(walk, {});
  MappingParams wide;
  wide.merging.chi_square = 100;
  wide.merging.max_error = 0.5;
  wide.merging.max_growth = 1.2;
  const Outcome undone = map_walk(walk, wide);
  int undos = 0;
  for (const Decision& d : undone.decisions) {
    show((d.accepted ? "+ " : "- ") + d.what + ": " + d.reason);
    if (d.reason.rfind("undone", 0) == 0) ++undos;
  }
  EXPECT_GE(undos, 1);
  EXPECT_EQ(undone.snapshot->planes.size(), usual.snapshot->planes.size());
  EXPECT_LT(undone.ate, 0.01);
}

const std::string loop = "loop keyframe/";

// A ring that only loop closing closes: planes are not recognised beyond a short distance, and nothing is merged.
TEST(Loops, CloseWhatWallsDoNot) {
  const Building building = ring();
  BuildingNoise noise = noise_of({"", 0.03, 0.004});
  noise.clouds = true;
  const auto walk = building.walls.walk(building.walk, 0.8, 0.2, noise, 15);
  MappingParams off;
  off.loops.enabled = false;
  off.merging.enabled = false;
  off.topological_layer = false;
  off.association.max_distance = 0.15;
  MappingParams on = off;
  on.loops.enabled = true;
  const Outcome without = map_walk(walk, off);
  const Outcome with = map_walk(walk, on);
  show("loops: odometry " + std::to_string(without.odometry_ate) + ", without " + std::to_string(without.ate) + ", with " + std::to_string(with.ate));
  int closed = 0;
  for (const Decision& d : with.decisions) {
    if (d.what.rfind(loop, 0) != 0) continue;
    show((d.accepted ? "+ " : "- ") + d.what + ": " + d.reason);
    closed += d.accepted;
  }
  EXPECT_GE(closed, 1);
  EXPECT_LT(with.ate, without.ate + 0.002);
}

int count_refused(const Outcome& result, const std::string& reason) {
  int refused = 0;
  for (const Decision& d : result.decisions) {
    if (d.what.rfind(loop, 0) != 0) continue;
    show((d.accepted ? "+ " : "- ") + d.what + ": " + d.reason);
    refused += !d.accepted && d.reason.find(reason) != std::string::npos;
  }
  return refused;
}

// Every room looks like the next one, and loops are looked for everywhere.
TEST(Loops, DoNotTakeARoomForItsTwin) {
  const Building building = alike();
  BuildingNoise noise = noise_of({"", 0.01, 0.002});
  noise.clouds = true;
  const auto walk = building.walls.walk(building.walk, 0.8, 0.2, noise, 16);
  MappingParams eager;
  eager.loops.min_sigma = 0;
  eager.loops.min_path = 6;
  eager.loops.min_interval = 3;
  eager.loops.max_distance = 6;
  const Outcome result = map_walk(walk, eager);
  EXPECT_GE(count_refused(result, "too few points have a match"), 1);
  EXPECT_LT(result.ate, 0.01);
}

// Scan matching says yes, the graph says no: on the second lap the clouds are those of places 2.4 m further on.
TEST(Loops, ThatContradictTheGraphAreRefused) {
  const Building building = ring();
  BuildingNoise noise;
  noise.clouds = true;
  auto walk = building.walls.walk(building.walk, 0.8, 0.2, noise, 18);
  const std::size_t lap = walk.size() / 2;
  for (std::size_t k = lap; k + 4 < walk.size(); ++k) walk[k].keyframe.cloud = walk[k - lap + 4].keyframe.cloud;
  MappingParams eager;
  eager.loops.min_sigma = 0;
  eager.loops.min_interval = 2;
  const Outcome result = map_walk(walk, eager);
  EXPECT_GE(count_refused(result, "contradicts the graph"), 1);
  EXPECT_LT(result.ate, 0.01);
}

// A graph that can't tell how far off a loop may be refuses it, and says so: that something is unknown doesn't make it exact.
TEST(Loops, OfUnknownUncertaintyAreRefusedAloud) {
  const Building building = ring();
  BuildingNoise noise;
  noise.clouds = true;
  auto walk = building.walls.walk(building.walk, 0.8, 0.2, noise, 17);
  MappingParams params;
  params.merging.enabled = false;
  params.topological_layer = false;
  // One odometry factor of no weight, and from then on no planes: nothing holds the second half to the first.
  for (std::size_t k = 0; k < walk.size(); ++k) walk[k].segments.segments.clear();
  walk[20].keyframe.covariance *= 1e30;
  const Outcome result = map_walk(walk, params);
  for (const Decision& d : result.decisions) EXPECT_FALSE(d.accepted && d.what.rfind(loop, 0) == 0) << d.reason;
  EXPECT_GE(count_refused(result, "doesn't know"), 1);
}

}  // namespace
}  // namespace sgraph
