#include "sgraph_slam/core/graph/graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "factor_cases.hpp"
#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/graph/solver.hpp"

namespace sgraph::test {
namespace {

// Keyframes 0..2 seeing planes 0..5, a room and a corridor on them, and one factor of every kind.
Graph building(unsigned seed) {
  Draw draw(seed);
  Transaction t;
  for (int k = 0; k < 3; ++k) t.keyframes[KeyframeId{k}] = draw.pose();
  const Eigen::Vector3d normals[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {1, 0, 0}};
  for (int p = 0; p < 6; ++p) t.planes[PlaneId{p}] = draw.near(Plane{normals[p], draw.uniform(1, 5)}, 0.01, 0.01);
  t.rooms[RoomId{0}] = draw.room();
  t.corridors[CorridorId{0}] = draw.corridor();
  Graph graph;
  EXPECT_TRUE(graph.apply(t).ok());

  Transaction factors;
  for (int kind = 0; kind < factor_kinds; ++kind) factors.factors.push_back({random_factor(draw, kind, graph), RobustLoss::huber(1.5)});
  for (int k = 0; k < 3; ++k) {
    for (int p = 0; p < 6; ++p) {
      const Pose T_base_lidar = draw.pose();
      const Plane seen = (*graph.find(KeyframeId{k}) * T_base_lidar).inverse() * *graph.find(PlaneId{p});
      factors.factors.push_back({PosePlane{{k}, {p}, seen, T_base_lidar, draw.weight<3>()}, {}});
    }
  }
  const RoomSide sides[] = {RoomSide::x_low, RoomSide::x_high, RoomSide::y_low, RoomSide::y_high};
  for (int s = 0; s < 4; ++s) factors.factors.push_back({RoomPlane{{0}, {s}, sides[s]}, {}});
  factors.factors.push_back({RoomPlane{{0}, {4}, RoomSide::x_low}, {}});  // plane 4 is a duplicate of plane 0
  factors.factors.push_back({ParallelPlanes{{0}, {4}}, {}});
  factors.factors.push_back({ParallelPlanes{{4}, {5}}, {}});
  factors.factors.push_back({PerpendicularPlanes{{5}, {2}}, {}});
  EXPECT_TRUE(graph.apply(factors).ok());
  return graph;
}

TEST(Graph, GivesFactorsIdsInOrderAndFindsThemByVariable) {
  const Graph graph = building(1);
  std::int64_t expected = 0;
  for (const auto& [id, factor] : graph.factors()) {
    EXPECT_EQ(id.value, expected++);
    for (const VariableId& variable : blocks(factor.data)) EXPECT_EQ(graph.factors_of(variable).count(id), 1u);
  }
  EXPECT_TRUE(graph.factors_of(PlaneId{99}).empty());
  EXPECT_EQ(graph.find(PlaneId{99}), nullptr);
}

void expect_refused(const Transaction& t, Refusal refusal, const char* word) {
  Graph graph = building(2);
  const Graph before = graph;
  const Applied applied = graph.apply(t);
  EXPECT_EQ(applied.refusal, refusal) << to_string(applied.refusal) << ": " << applied.detail;
  EXPECT_NE(applied.detail.find(word), std::string::npos) << applied.detail;
  EXPECT_TRUE(graph == before);
}

// An edit that would be fine by itself: nothing of it may stay when another part is refused.
Transaction fine_edit() {
  Transaction t;
  t.keyframes[KeyframeId{3}] = Pose{};
  t.factors.push_back({Se3Between{{2}, {3}, Pose{}, {}}, {}});
  t.remove_factors.push_back(FactorId{0});
  t.merges.push_back({PlaneId{0}, PlaneId{4}});
  return t;
}

TEST(Graph, DoesNotKnowEditsOfLongAgo) {
  Graph graph = building(1);
  const std::int64_t long_ago = graph.factors_edited();
  EXPECT_TRUE(graph.factors_edited_since(long_ago)->empty());
  EXPECT_FALSE(graph.factors_edited_since(-1).has_value());
  EXPECT_FALSE(graph.factors_edited_since(long_ago + 1).has_value());
  const Factor kept = graph.factors().begin()->second;
  while (graph.factors_edited() < long_ago + 5000) {
    Transaction t;
    t.remove_factors = {graph.factors().rbegin()->first};
    t.factors = {kept};
    ASSERT_TRUE(graph.apply(t).ok());
  }
  EXPECT_FALSE(graph.factors_edited_since(long_ago).has_value());
  EXPECT_EQ(graph.factors_edited_since(graph.factors_edited() - 1)->size(), 1u);
}

TEST(Transaction, RefusesUnknownAndUsedIds) {
  EXPECT_TRUE(building(2).apply(fine_edit()).ok());
  Transaction t = fine_edit();
  t.factors.push_back({Se3Between{{2}, {7}, Pose{}, {}}, {}});
  expect_refused(t, Refusal::unknown_id, "keyframe/7");
  t = fine_edit();
  t.planes[PlaneId{3}] = Plane{};
  expect_refused(t, Refusal::duplicate_id, "plane/3");
  t = fine_edit();
  t.planes[PlaneId{}] = Plane{};
  expect_refused(t, Refusal::duplicate_id, "plane/-1");
  t = fine_edit();
  t.remove_factors.push_back(FactorId{1000});
  expect_refused(t, Refusal::unknown_id, "1000");
  t = fine_edit();
  t.remove_factors.push_back(FactorId{0});  // twice
  expect_refused(t, Refusal::unknown_id, "factor 0");
  t = fine_edit();
  t.remove_variables.push_back(RoomId{5});
  expect_refused(t, Refusal::unknown_id, "room/5");
  t = fine_edit();
  t.merges.push_back({PlaneId{0}, PlaneId{4}});  // 4 is gone by then
  expect_refused(t, Refusal::unknown_id, "plane/4");
  t = fine_edit();
  t.remove_variables.push_back(PlaneId{0});
  expect_refused(t, Refusal::unknown_id, "plane/0");
  t = fine_edit();
  t.undo_merges.push_back(PlaneId{4});
  expect_refused(t, Refusal::unknown_id, "plane/4");
}

TEST(Transaction, RefusesWhatIsNotFinite) {
  const double nan = std::nan("");
  Transaction t = fine_edit();
  t.keyframes[KeyframeId{4}].translation.x() = nan;
  expect_refused(t, Refusal::not_finite, "keyframe/4");
  t = fine_edit();
  t.planes[PlaneId{9}] = Plane{{1, 1, 0}, 0};
  expect_refused(t, Refusal::not_finite, "plane/9");
  t = fine_edit();
  t.planes[PlaneId{9}] = Plane{{1, 0, 0}, INFINITY};
  expect_refused(t, Refusal::not_finite, "plane/9");
  t = fine_edit();
  t.keyframes[KeyframeId{4}].rotation.coeffs().setZero();
  expect_refused(t, Refusal::not_finite, "keyframe/4");
  t = fine_edit();
  t.rooms[RoomId{9}].width.x() = nan;
  expect_refused(t, Refusal::not_finite, "room/9");
  t = fine_edit();
  t.factors.push_back({ParallelPlanes{{0}, {1}, 0.0}, {}});
  expect_refused(t, Refusal::not_finite, "parallel_planes");
  t = fine_edit();
  t.factors.push_back({PosePlane{{0}, {1}, Plane{}, Pose{}, SqrtInformation<3>::from_std_dev({0.1, 0.0, 0.1})}, {}});
  expect_refused(t, Refusal::not_finite, "pose_plane");
  t = fine_edit();
  t.factors.push_back({RoomWidth{{0}, {0}, 2, 3.0}, {}});
  expect_refused(t, Refusal::not_finite, "room_width");
  t = fine_edit();
  t.factors.push_back({ParallelPlanes{{0}, {1}}, RobustLoss::huber(-1)});
  expect_refused(t, Refusal::not_finite, "parallel_planes");
}

TEST(Transaction, RefusesSelfFactorsAndMergesOfTwoFaces) {
  Transaction t = fine_edit();
  t.factors.push_back({ParallelPlanes{{1}, {1}}, {}});
  expect_refused(t, Refusal::invalid_factor, "plane/1");
  t = fine_edit();
  t.merges.push_back({PlaneId{0}, PlaneId{0}});
  expect_refused(t, Refusal::invalid_factor, "plane/0");
  t = fine_edit();
  t.merges.push_back({PlaneId{0}, PlaneId{1}});
  expect_refused(t, Refusal::opposed_planes, "plane/1");
}

TEST(Transaction, RemovesAVariableWithItsFactors) {
  Graph graph = building(3);
  Transaction t;
  t.remove_variables = {RoomId{0}, PlaneId{2}};
  ASSERT_TRUE(graph.apply(t).ok());
  EXPECT_EQ(graph.find(RoomId{0}), nullptr);
  for (const auto& [id, factor] : graph.factors()) {
    for (const VariableId& variable : blocks(factor.data)) EXPECT_TRUE(graph.contains(variable)) << type_name(factor.data);
  }
}

TEST(Transaction, FreshIdsAreNeverGivenTwice) {
  Graph graph = building(3);
  const PlaneId fresh = graph.new_plane_id();
  EXPECT_EQ(fresh.value, 6);
  Transaction t;
  t.planes[fresh] = Plane{};
  t.planes[PlaneId{9}] = Plane{};
  ASSERT_TRUE(graph.apply(t).ok());
  Transaction remove;
  remove.remove_variables = {PlaneId{9}};
  ASSERT_TRUE(graph.apply(remove).ok());
  EXPECT_EQ(graph.new_plane_id().value, 10);
}

TEST(Merge, KeepsEveryObservationAndOneCopyOfEachStatement) {
  Graph graph = building(4);
  const std::size_t of_both = graph.factors_of(PlaneId{0}).size() + graph.factors_of(PlaneId{4}).size();
  Transaction t;
  t.merges = {{PlaneId{0}, PlaneId{4}}};
  ASSERT_TRUE(graph.apply(t).ok());
  EXPECT_EQ(graph.find(PlaneId{4}), nullptr);
  EXPECT_EQ(graph.representative(PlaneId{4}), PlaneId{0});
  // Gone: the parallel factor between the two (it was both's), and the second copy of the room's wall at x_low.
  EXPECT_EQ(graph.factors_of(PlaneId{0}).size(), of_both - 3);
  int observations = 0;
  int walls = 0;
  for (const FactorId id : graph.factors_of(PlaneId{0})) {
    const FactorData& data = graph.find(id)->data;
    observations += std::holds_alternative<PosePlane>(data) ? 1 : 0;
    const auto* wall = std::get_if<RoomPlane>(&data);
    walls += wall != nullptr && wall->side == RoomSide::x_low ? 1 : 0;
  }
  EXPECT_EQ(observations, 7);  // three each, and one of the case's own
  EXPECT_EQ(walls, 1);
}

TEST(Merge, UndoGivesBackTheFactorsAndThePlaneWhereItIsSeenNow) {
  Graph graph = building(5);
  const Graph before = graph;
  Transaction t;
  t.merges = {{PlaneId{0}, PlaneId{4}}};
  ASSERT_TRUE(graph.apply(t).ok());
  // The first keyframe moves, and the plane goes with its first observation.
  const Pose shift{Eigen::Quaterniond::Identity(), {0.3, -0.2, 0.1}};
  graph.set(KeyframeId{0}, shift * *graph.find(KeyframeId{0}));
  Transaction undo;
  undo.undo_merges = {PlaneId{4}};
  ASSERT_TRUE(graph.apply(undo).ok());
  EXPECT_TRUE(graph.merges().empty());
  EXPECT_TRUE(graph.factors() == before.factors());
  const Plane expected = shift * *before.find(PlaneId{4});
  EXPECT_LT((graph.find(PlaneId{4})->normal - expected.normal).norm(), 1e-9);
  EXPECT_NEAR(graph.find(PlaneId{4})->d, expected.d, 1e-9);
}

TEST(Merge, ObservationsMadeSinceStayWithTheKeptPlane) {
  Graph graph = building(6);
  Transaction t;
  t.merges = {{PlaneId{0}, PlaneId{4}}};
  ASSERT_TRUE(graph.apply(t).ok());
  Transaction later;
  later.factors.push_back({PosePlane{{2}, {0}, Plane{}, Pose{}, {}}, {}});
  const FactorId observation = graph.apply(later).factors.at(0);
  Transaction undo;
  undo.undo_merges = {PlaneId{4}};
  ASSERT_TRUE(graph.apply(undo).ok());
  EXPECT_EQ(graph.factors_of(PlaneId{0}).count(observation), 1u);
  EXPECT_EQ(graph.factors_of(PlaneId{4}).count(observation), 0u);
}

TEST(Merge, AnyOrderOfMergesAndUndosComesBack) {
  const PlaneId same_side[] = {{0}, {4}, {5}};
  for (unsigned seed = 0; seed < 200; ++seed) {
    Draw draw(seed);
    Graph graph = building(7);
    const Graph before = graph;
    std::vector<PlaneId> standing(std::begin(same_side), std::end(same_side));
    while (standing.size() > 1) {
      const auto kept = static_cast<std::size_t>(draw.below(static_cast<int>(standing.size())));
      const auto merged = (kept + 1 + static_cast<std::size_t>(draw.below(static_cast<int>(standing.size()) - 1))) % standing.size();
      Transaction t;
      t.merges = {{standing[kept], standing[merged]}};
      ASSERT_TRUE(graph.apply(t).ok());
      standing.erase(standing.begin() + static_cast<std::ptrdiff_t>(merged));
    }
    EXPECT_TRUE(graph_from_json(to_json(graph)) == graph);
    while (!graph.merges().empty()) {
      Transaction undo;
      undo.undo_merges = {std::next(graph.merges().begin(), draw.below(static_cast<int>(graph.merges().size())))->first};
      ASSERT_TRUE(graph.apply(undo).ok());
      EXPECT_TRUE(graph_from_json(to_json(graph)) == graph);
    }
    ASSERT_TRUE(graph.factors() == before.factors()) << "seed " << seed;
  }
}

TEST(Merge, RemovingTheEndOfAChainTakesTheWholeChainWithIt) {
  Graph graph = building(4);
  // Ids along the chain rise in one test and fall in the other: records are visited by id.
  for (const auto& chain : {std::vector<PlaneId>{{0}, {4}, {5}}, std::vector<PlaneId>{{5}, {4}, {0}}}) {
    Graph changed = graph;
    Transaction first;
    first.merges = {{chain[1], chain[0]}};
    ASSERT_TRUE(changed.apply(first).ok());
    Transaction second;
    second.merges = {{chain[2], chain[1]}};
    ASSERT_TRUE(changed.apply(second).ok());
    Transaction remove;
    remove.remove_variables = {chain[2]};
    ASSERT_TRUE(changed.apply(remove).ok());
    EXPECT_TRUE(changed.merges().empty());
    EXPECT_TRUE(graph_from_json(to_json(changed)) == changed);
  }
}

// Whether the graph hangs together: every factor names variables that are there, every merge leads to a plane that is there, and what an undo would
// bring back names nothing that is gone for good.
void expect_sound(const Graph& graph) {
  for (const auto& [id, factor] : graph.factors()) {
    for (const VariableId& variable : blocks(factor.data)) {
      ASSERT_TRUE(graph.contains(variable)) << type_name(factor.data) << " names " << to_string(variable);
      ASSERT_EQ(graph.factors_of(variable).count(id), 1u);
    }
  }
  for (const auto& [merged, record] : graph.merges()) {
    ASSERT_FALSE(graph.contains(merged));
    ASSERT_TRUE(graph.contains(graph.representative(merged))) << "plane " << merged.value;
    for (const auto& [id, factor] : record.dropped) {
      for (const VariableId& variable : blocks(factor.data)) {
        const auto* plane = std::get_if<PlaneId>(&variable);
        ASSERT_TRUE(graph.contains(plane ? VariableId(graph.representative(*plane)) : variable)) << to_string(variable);
      }
    }
  }
}

template <class Map, class Random>
auto any_of(const Map& map, Random& draw) {
  return std::next(map.begin(), draw.below(static_cast<int>(map.size())))->first;
}

// One edit drawn at random; small ones most of the time, several steps in one now and then.
Transaction random_edit(Graph& graph, Draw& draw) {
  Transaction t;
  const int kind = draw.below(10);
  if (kind < 3) {
    const PlaneId plane = graph.new_plane_id();
    t.planes[plane] = draw.near(Plane{{1, 0, 0}, draw.uniform(1, 5)}, 0.01, 0.01);
    for (int i = 0; i < 3; ++i) add_factor(t, PosePlane{any_of(graph.keyframes(), draw), plane, Plane{}, Pose{}, {}});
    if (!graph.planes().empty()) add_factor(t, ParallelPlanes{any_of(graph.planes(), draw), plane});
    if (!graph.rooms().empty()) add_factor(t, RoomPlane{any_of(graph.rooms(), draw), plane, draw.below(2) == 0 ? RoomSide::x_low : RoomSide::y_high});
  }
  if (kind == 3) t.rooms[graph.new_room_id()] = draw.room();
  if (kind >= 4 && kind < 8 && graph.planes().size() > 1) t.merges = {{any_of(graph.planes(), draw), any_of(graph.planes(), draw)}};
  if (kind >= 7 && !graph.merges().empty()) t.undo_merges = {any_of(graph.merges(), draw)};
  if (kind == 8 && !graph.planes().empty()) t.remove_variables.emplace_back(any_of(graph.planes(), draw));
  if (kind == 8 && draw.below(3) == 0 && !graph.rooms().empty()) t.remove_variables.emplace_back(any_of(graph.rooms(), draw));
  if (kind == 9 && draw.below(4) == 0 && graph.keyframes().size() > 1) t.remove_variables.emplace_back(any_of(graph.keyframes(), draw));
  if (kind == 9 && !graph.factors().empty()) t.remove_factors = {any_of(graph.factors(), draw)};
  return t;
}

// What one edit has changed of the factors known before it, against what the graph says of it.
void expect_edits_known(const Graph& before, const Graph& after) {
  const auto edited = after.factors_edited_since(before.factors_edited());
  ASSERT_TRUE(edited.has_value());
  for (const auto& [id, factor] : before.factors()) {
    const Factor* now = after.find(id);
    const bool changed = now == nullptr || !(*now == factor);
    ASSERT_TRUE(!changed || edited->count(id) == 1) << id.value;
  }
  for (const auto& [id, factor] : after.factors()) {
    const bool is_between = !before.factors().empty() && id < before.factors().rbegin()->first;
    ASSERT_TRUE(!is_between || before.find(id) != nullptr || edited->count(id) == 1) << id.value;
  }
}

TEST(Transaction, AnySequenceLeavesAGraphThatIsSoundAndReadsBack) {
  int merged = 0;
  int undone = 0;
  int removed = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    Draw draw(seed);
    Graph graph;
    Transaction start;
    for (int k = 0; k < 5; ++k) start.keyframes[KeyframeId{k}] = draw.pose();
    ASSERT_TRUE(graph.apply(start).ok());
    for (int step = 0; step < 60; ++step) {
      const Transaction t = random_edit(graph, draw);
      const Graph before = graph;
      if (!graph.apply(t).ok()) {
        ASSERT_TRUE(graph == before);
        continue;
      }
      merged += static_cast<int>(t.merges.size());
      undone += static_cast<int>(t.undo_merges.size());
      removed += static_cast<int>(t.remove_variables.size());
      ASSERT_NO_FATAL_FAILURE(expect_sound(graph)) << "seed " << seed << ", step " << step;
      ASSERT_NO_FATAL_FAILURE(expect_edits_known(before, graph)) << "seed " << seed << ", step " << step;
      ASSERT_NO_THROW(ASSERT_TRUE(graph_from_json(to_json(graph)) == graph)) << "seed " << seed << ", step " << step;
    }
    while (!graph.merges().empty()) {
      Transaction undo;
      undo.undo_merges = {any_of(graph.merges(), draw)};
      ASSERT_TRUE(graph.apply(undo).ok());
      ASSERT_NO_FATAL_FAILURE(expect_sound(graph)) << "seed " << seed;
    }
  }
  EXPECT_GT(merged, 500);
  EXPECT_GT(undone, 200);
  EXPECT_GT(removed, 200);
}

TEST(Serialization, AGraphRebuiltIsEqual) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    Graph graph = building(seed);
    Transaction t;
    t.merges = {{PlaneId{0}, PlaneId{4}}};
    ASSERT_TRUE(graph.apply(t).ok());
    graph.new_room_id();
    const Graph again = graph_from_json(to_json(graph));
    ASSERT_TRUE(again == graph);
    EXPECT_EQ(total_cost(again), total_cost(graph));
    Graph changed = again;
    changed.set(PlaneId{1}, Plane{{0, 0, 1}, 2.0});
    EXPECT_FALSE(changed == graph);
  }
}

TEST(Serialization, BadTextIsRefusedWithAReason) {
  const std::string good = to_json(building(1));
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  EXPECT_NO_THROW(graph_from_json(good));
  for (const std::string& text : {std::string(), std::string("[]"), std::string("{}"), good.substr(0, good.size() / 2),
                                  with("\"format\":1", "\"format\":2"), with("pose_plane\"", "pose_plank\""), with("\"plane\":3", "\"plane\":33"),
                                  with("\"huber\"", "\"hubris\""), with("\"sigma\":0", "\"sigma\":-0"), with("\"normal\":[", "\"normal\":[3,")}) {
    EXPECT_THROW(graph_from_json(text), std::runtime_error) << text.substr(0, 60);
  }
}

}  // namespace
}  // namespace sgraph::test
