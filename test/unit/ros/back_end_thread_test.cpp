#include "sgraph_slam/ros/back_end_thread.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <thread>

#include "sgraph_slam/core/store/stored_map.hpp"
#include "support/mapping_run.hpp"

namespace sgraph {
namespace {

using std::chrono::seconds;

MatchedKeyframe matched(const SeenKeyframe& seen) {
  MatchedKeyframe keyframe;
  keyframe.received.keyframe = seen.keyframe;
  keyframe.received.T_base_lidar = MappedBuilding::T_base_lidar();
  keyframe.segments = seen.segments;
  return keyframe;
}

std::vector<SeenKeyframe> walk_with_clouds() {
  BuildingNoise noise;
  noise.clouds = true;
  MappedBuilding building;
  building.add_room(0, 0, 6, 5, {{}, {{2, 3}}, {}, {}});
  building.add_room(6.15, 0, 12, 5, {{}, {}, {}, {{2, 3}}});
  return building.walk({{1, 1}, {4, 1}, {4, 2.5}, {9, 2.5}, {9, 4}, {7, 2.5}, {3, 2.5}, {1, 1}}, 0.4, 0.2, noise, 4);
}

// Keyframes come faster than they are mapped, while services ask and readers read: nothing is lost, and the map is that of the same keyframes alone.
TEST(BackEndThread, UnderLoadTheMapIsTheSame) {
  const auto walk = walk_with_clouds();
  BackEnd alone({}, MappedBuilding::T_base_lidar());
  for (const SeenKeyframe& seen : walk) alone.process(seen.keyframe, seen.segments);

  std::atomic<int> states{0};
  std::size_t told = 0;
  std::string failure;
  std::int64_t number = 0;
  bool in_order = true;
  BackEndThread thread(
      {}, "site", "", {},
      [&](const LiveMap& state, double) {
        ++states;
        told += state.decided.size();
        in_order = in_order && state.number > number;
        number = state.number;
      },
      [&](const std::string& text) { failure = text; });
  std::atomic<bool> done{false};
  std::vector<std::thread> readers;
  std::atomic<int> wrong{0};
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&] {
      std::size_t least = 0;
      while (!done) {
        const LiveMap state = thread.state();
        if (state.graph->frame != "site" || state.graph->keyframes.size() < least) ++wrong;
        least = state.graph->keyframes.size();
        for (const auto& [id, keyframe] : state.graph->keyframes) {
          if (id.value % 16 == 0 && (!keyframe.cloud.get() || keyframe.cloud.get()->empty())) ++wrong;  // read back while others are written
        }
        std::this_thread::yield();
      }
    });
  }
  for (const SeenKeyframe& seen : walk) thread.process(matched(seen));
  while (static_cast<std::size_t>(states) < walk.size()) std::this_thread::yield();
  const LiveMap last = thread.state();
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_TRUE(in_order);
  EXPECT_EQ(failure, "");
  ASSERT_EQ(last.graph->keyframes.size(), walk.size());
  for (const auto& [id, keyframe] : alone.snapshot()->keyframes)
    EXPECT_EQ(keyframe.T_map_base.translation, last.graph->keyframes.at(id).T_map_base.translation) << id.value;
  EXPECT_EQ(told, alone.decisions().size());  // each once
}

TEST(BackEndThread, AServiceWaitsForWhatCameBeforeIt) {
  const auto walk = walk_with_clouds();
  std::atomic<int> states{0};
  BackEndThread thread(
      {}, "map", "", {}, [&](const LiveMap&, double) { ++states; }, [](const std::string&) {});
  EXPECT_TRUE(thread.optimize(seconds(60))->graph->keyframes.empty());
  for (const SeenKeyframe& seen : walk) thread.process(matched(seen));
  EXPECT_FALSE(thread.optimize(std::chrono::milliseconds(0)).has_value());  // busy: it will be done all the same
  const auto optimized = thread.optimize(seconds(120));
  ASSERT_TRUE(optimized.has_value());
  EXPECT_EQ(optimized->graph->keyframes.size(), walk.size());
  EXPECT_NE(optimized->graph->factors_json, "[]");
  for (const SeenKeyframe& seen : walk) thread.process(matched(seen));  // the recording again: another map
  ASSERT_TRUE(thread.reset(seconds(120)));
  EXPECT_TRUE(thread.state().graph->keyframes.empty());
  thread.process(matched(walk.front()));
  EXPECT_EQ(thread.optimize(seconds(120))->graph->keyframes.size(), 1U);
}

// A recording that is played again goes into the map that was taken up as one more session: what the first one wrote is known by then.
TEST(BackEndThread, ARecordingPlayedTwiceIsTwoSessionsOfTheMapTakenUp) {
  std::string folder = (std::filesystem::temp_directory_path() / "thread-XXXXXX").string();
  folder = mkdtemp(folder.data());
  const std::string path = folder + "/map.sgmap";
  const auto walk = walk_with_clouds();
  std::vector<std::string> failures;
  const auto failed = [&](const std::string& text) { failures.push_back(text); };
  {
    BackEndThread thread(
        {}, "map", path, {}, [](const LiveMap&, double) {}, failed);
    for (const SeenKeyframe& seen : walk) thread.process(matched(seen));
    ASSERT_TRUE(thread.optimize(seconds(100)));
  }
  {
    BackEndThread thread(
        {}, "map", path, make_start(path, "continue", "first"), [](const LiveMap&, double) {}, failed);
    for (int times = 0; times < 2; ++times) {
      for (const SeenKeyframe& seen : walk) thread.process(matched(seen));
      const auto state = thread.optimize(seconds(100));
      ASSERT_TRUE(state);
      EXPECT_TRUE(state->placed) << state->localisation->reason;
    }
  }
  EXPECT_TRUE(failures.empty()) << failures.front();
  EXPECT_EQ(check_map(path), std::vector<std::string>{});
  const MapSummary summary = summarize_map(path);
  ASSERT_EQ(summary.sessions.size(), 3U);
  for (const MapSummary::Session& session : summary.sessions) EXPECT_EQ(session.keyframes, static_cast<std::int64_t>(walk.size()));
  std::filesystem::remove_all(folder);
}

// Where no map file can be written that is said as long as it lasts, and mapping goes on.
TEST(BackEndThread, AMapThatCannotBeWrittenIsSaidWithEachState) {
  std::vector<std::string> failures;
  BackEndThread thread(
      {}, "map", "/proc/map.sgmap", {}, [](const LiveMap&, double) {}, [&](const std::string& text) { failures.push_back(text); });
  const auto walk = walk_with_clouds();
  for (std::size_t i = 0; i < 5; ++i) {
    thread.process(matched(walk[i]));
    const auto state = thread.optimize(seconds(100));
    ASSERT_TRUE(state);
    EXPECT_EQ(state->graph->keyframes.size(), i + 1);
    EXPECT_NE(state->store_problem.find("no map file is written"), std::string::npos) << state->store_problem;
  }
  EXPECT_EQ(failures.size(), 1U);
}

}  // namespace
}  // namespace sgraph
