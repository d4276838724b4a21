#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/io/temporary_clouds.hpp"
#include "sgraph_slam/core/mapping/back_end.hpp"
#include "sgraph_slam/core/store/cloud_codec.hpp"
#include "sgraph_slam/core/store/map_recorder.hpp"
#include "sgraph_slam/core/store/map_store.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"
#include "support/mapped_building.hpp"

namespace sgraph {
namespace {

using std::chrono::seconds;

class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "store-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~Folder() {
    std::error_code error;
    std::filesystem::permissions(path_, std::filesystem::perms::owner_all, error);
    std::filesystem::remove_all(path_, error);
  }
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + '/' + name; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

StoredSession session() {
  StoredSession session;
  session.source = "test";
  session.T_base_lidar = MappedBuilding::T_base_lidar();
  return session;
}

Cloud some_cloud(unsigned seed, std::size_t size = 200) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> at(-20, 20);
  Cloud cloud;
  cloud.stamp = Stamp::from_seconds(seed);
  cloud.frame = "velodyne";
  for (std::size_t i = 0; i < size; ++i) {
    cloud.points.push_back(
        {at(random), at(random), at(random), static_cast<float>(i % 256), -0.01F * static_cast<float>(i % 10), static_cast<std::uint16_t>(i % 16)});
  }
  cloud.viewpoints = {{-0.1, {0.1, 0.2, 0.3}}, {0, {0, 0, 0}}};
  return cloud;
}

Keyframe keyframe(std::int64_t id) {
  Keyframe keyframe;
  keyframe.id = {id};
  keyframe.stamp = Stamp::from_seconds(100 + static_cast<double>(id));
  keyframe.T_odom_base.translation = {0.5 * static_cast<double>(id), 0.1, 0};
  keyframe.scans = {{keyframe.stamp.after(-0.1), keyframe.T_odom_base}, {keyframe.stamp, keyframe.T_odom_base}};
  keyframe.degenerate = {Vector6::Unit(3)};
  keyframe.cloud = std::make_shared<const Cloud>(some_cloud(static_cast<unsigned>(id)));
  return keyframe;
}

StoreBatch batch_of(std::int64_t id) {
  StoreBatch batch;
  batch.keyframes.push_back(keyframe(id));
  batch.poses.emplace_back(KeyframeId{id}, batch.keyframes.back().T_odom_base);
  if (id > 0)
    batch.factors[{id}].data = Se3Between{
        {id - 1}, {id}, {}, SqrtInformation<6>::from_covariance(Matrix6::Identity(), Vector6::Constant(1e-6)), Se3Between::Source::odometry};
  return batch;
}

TEST(CloudCodec, KeepsWhatTheSensorResolves) {
  const Cloud cloud = some_cloud(3, 5000);
  const std::string bytes = encode_cloud(cloud);
  EXPECT_LT(bytes.size(), 12 * cloud.size());
  const Cloud back = decode_cloud(bytes);
  ASSERT_EQ(back.size(), cloud.size());
  EXPECT_EQ(back.frame, cloud.frame);
  EXPECT_EQ(back.stamp, cloud.stamp);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT((back.points[i].position() - cloud.points[i].position()).cwiseAbs().maxCoeff(), 0.00051);
    EXPECT_EQ(back.points[i].intensity, cloud.points[i].intensity);
    EXPECT_EQ(back.points[i].ring, cloud.points[i].ring);
    EXPECT_NEAR(back.points[i].time, cloud.points[i].time, 5.1e-6);
  }
  ASSERT_EQ(back.viewpoints.size(), 2U);
  EXPECT_EQ(back.viewpoints[0].position, cloud.viewpoints[0].position);
}

TEST(CloudCodec, FractionalIntensitiesKeepSixteenBits) {
  Cloud cloud = some_cloud(4);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.points[i].intensity = static_cast<float>(i) / 500.0F;
  const Cloud back = decode_cloud(encode_cloud(cloud));
  for (std::size_t i = 0; i < cloud.size(); ++i) EXPECT_NEAR(back.points[i].intensity, cloud.points[i].intensity, 1e-5);
}

TEST(CloudCodec, LeavesOutWhatIsNoPoint) {
  Cloud cloud = some_cloud(5, 10);
  cloud.points[3].y = NAN;
  cloud.points[4].x = INFINITY;
  cloud.points[5].z = 1e9F;
  EXPECT_EQ(decode_cloud(encode_cloud(cloud)).size(), 7U);
  EXPECT_EQ(decode_cloud(encode_cloud(Cloud{})).size(), 0U);
}

TEST(CloudCodec, RefusesDamage) {
  const std::string bytes = encode_cloud(some_cloud(6));
  EXPECT_THROW(decode_cloud(bytes.substr(0, bytes.size() / 2)), std::runtime_error);
  EXPECT_THROW(decode_cloud(""), std::runtime_error);
  for (std::size_t i = 0; i < bytes.size(); i += 97) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x55);
    EXPECT_THROW(decode_cloud(damaged), std::runtime_error) << i;
  }
}

MappedBuilding flat() {
  MappedBuilding building;
  building.add_room(0, 0, 6, 5, {{}, {}, {{2, 3}}, {}});
  building.add_room(0, 5.15, 6, 9, {{{3, 4}}, {}, {}, {}});
  return building;
}

std::vector<SeenKeyframe> flat_walk() {
  return flat().walk({{1, 1}, {5, 1}, {3.5, 4}, {3.5, 7}, {1, 8}, {5, 8}, {3.5, 7}, {3.5, 3}, {1, 1}}, 0.5, 0.3, {}, 2);
}

// All that graph.json tells can be made again from the file, to the last digit.
TEST(Store, HoldsTheWholeMap) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  BackEnd back_end({}, MappedBuilding::T_base_lidar());
  GraphSnapshotPtr final_state;
  {
    MapStore store(path, MapStore::Mode::create, session());
    MapRecorder recorder(store);
    back_end.observe(&recorder);
    for (SeenKeyframe seen : flat_walk()) {
      seen.keyframe.cloud = std::make_shared<const Cloud>(some_cloud(7));
      back_end.process(seen.keyframe, seen.segments);
    }
    final_state = back_end.optimize();
    ASSERT_TRUE(store.flush(seconds(20)));
    EXPECT_EQ(store.problem(), "");
  }
  const StoredMap map = read_map(path, Clouds::all);
  EXPECT_TRUE(map.faults.empty());
  GraphSnapshot again = snapshot_of(map);
  EXPECT_EQ(graph_json(again), graph_json(*final_state));
  ASSERT_EQ(again.decisions.size(), final_state->decisions.size());
  ASSERT_EQ(again.planes.size(), final_state->planes.size());
  for (const auto& [id, plane] : final_state->planes) ASSERT_EQ(again.planes.at(id).observations.size(), plane.observations.size());
  EXPECT_EQ(map.sessions.size(), 1U);
  EXPECT_EQ(map.sessions.begin()->second.source, "test");
  for (const auto& [id, keyframe] : map.keyframes) EXPECT_EQ(keyframe.cloud->size(), 200U);
  EXPECT_TRUE(check_map(path).empty());
  const MapSummary summary = summarize_map(path);
  EXPECT_EQ(summary.keyframes, static_cast<std::int64_t>(final_state->keyframes.size()));
  EXPECT_EQ(summary.rooms, static_cast<std::int64_t>(final_state->rooms.size()));
  EXPECT_EQ(summary.schema, store_schema);
}

// Who walks the same way for hours makes no larger file than the way needs.
TEST(Store, CloudsThatNobodyNeedsLeaveTheFile) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  MappingParams params;
  params.factors.spot_keyframes = 2;
  std::vector<Eigen::Vector2d> waypoints;
  for (int round = 0; round < 12; ++round) waypoints.insert(waypoints.end(), {{1, 1}, {5, 1}});
  BackEnd back_end(params, MappedBuilding::T_base_lidar(), std::make_shared<TemporaryClouds>());
  GraphSnapshotPtr final_state;
  std::size_t keyframes = 0;
  {
    MapStore store(path, MapStore::Mode::create, session());
    MapRecorder recorder(store);
    back_end.observe(&recorder);
    for (SeenKeyframe seen : flat().walk(waypoints, 0.5, 0.3, {}, 2)) {
      seen.keyframe.cloud = std::make_shared<const Cloud>(some_cloud(7));
      back_end.process(seen.keyframe, seen.segments);
      ++keyframes;
    }
    final_state = back_end.optimize();
    ASSERT_TRUE(store.flush(seconds(20)));
  }
  const StoredMap map = read_map(path, Clouds::all);
  EXPECT_TRUE(map.faults.empty());
  EXPECT_TRUE(check_map(path).empty());
  std::size_t with_cloud = 0;
  for (const auto& [id, keyframe] : map.keyframes) {
    EXPECT_EQ(keyframe.cloud != nullptr, final_state->keyframes.at(id).cloud.get() != nullptr) << id.value;
    with_cloud += keyframe.cloud != nullptr ? 1 : 0;
  }
  EXPECT_EQ(map.keyframes.size(), keyframes);
  EXPECT_LT(2 * with_cloud, keyframes);
  EXPECT_GT(with_cloud, 10U);
}

// A reader sees what was written while the map still grows.
TEST(Store, IsReadWhileItIsWritten) {
  const Folder folder;
  MapStore store(folder.file("map.sgmap"), MapStore::Mode::create, session());
  for (std::int64_t id = 0; id < 5; ++id) store.write(batch_of(id));
  ASSERT_TRUE(store.flush(seconds(20)));
  EXPECT_EQ(read_map(store.path(), Clouds::none).keyframes.size(), 5U);
  store.write(batch_of(5));
  ASSERT_TRUE(store.flush(seconds(20)));
  EXPECT_EQ(read_map(store.path(), Clouds::none).keyframes.size(), 6U);
}

TEST(Store, AFurtherSessionGoesIntoTheSameFile) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  { MapStore(path, MapStore::Mode::create, session()).write(batch_of(0)); }
  { MapStore(path, MapStore::Mode::extend, session()).write(batch_of(1)); }
  const StoredMap map = read_map(path, Clouds::none);
  EXPECT_EQ(map.sessions.size(), 2U);
  EXPECT_EQ(map.session_of.at({1}), 1);
  EXPECT_THROW(MapStore(path, MapStore::Mode::create, session()), StoreError);
  EXPECT_EQ(read_map(path, Clouds::none).keyframes.size(), 2U);
}

TEST(Store, AMapIsSetAsideNotOverwritten) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  EXPECT_EQ(set_aside(path), "");
  for (const char* name : {"map.before.sgmap", "map.before-2.sgmap"}) {
    { MapStore(path, MapStore::Mode::create, session()).write(batch_of(0)); }
    EXPECT_EQ(set_aside(path), folder.file(name));
    EXPECT_FALSE(std::filesystem::exists(path));
    EXPECT_EQ(read_map(folder.file(name), Clouds::none).keyframes.size(), 1U);
  }
}

TEST(Store, TheNewestFewAreKeptAside) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  write_file(folder.file("map.before-yesterday.sgmap"), "the user's own");
  for (std::int64_t id = 1; id <= 9; ++id) {
    { MapStore(path, MapStore::Mode::create, session()).write(batch_of(id)); }
    set_aside(path);
  }
  for (int number = 1; number <= 9; ++number) {
    const std::string name = folder.file("map.before" + (number > 1 ? '-' + std::to_string(number) : "") + ".sgmap");
    ASSERT_EQ(std::filesystem::exists(name), number > 4) << name;
    if (number > 4) {
      EXPECT_EQ(read_map(name, Clouds::none).keyframes.begin()->first.value, number);
    }
  }
  EXPECT_TRUE(std::filesystem::exists(folder.file("map.before-yesterday.sgmap")));
}

// A file as each released schema wrote it, read for ever. SGRAPH_WRITE_SAMPLE=FOLDER writes one of the present schema, with the graph.json to compare
// it with.
constexpr const char* samples = "test/data/store";

void write_sample(const std::string& folder) {
  const std::string name = folder + "/schema_" + std::to_string(store_schema);
  MappingParams params;
  params.factors.spot_keyframes = 1;  // some keyframes are retired
  BackEnd back_end(params, MappedBuilding::T_base_lidar());
  MapStore store(name + ".sgmap", MapStore::Mode::create, session());
  MapRecorder recorder(store);
  back_end.observe(&recorder);
  for (SeenKeyframe seen : flat().walk({{1, 1}, {5, 1}, {3, 3}, {1, 1}, {5, 1}, {3, 3}, {1, 1}, {5, 1}}, 1.2, 0.3, {}, 2)) {
    seen.keyframe.cloud = std::make_shared<const Cloud>(some_cloud(7, 40));
    back_end.process(seen.keyframe, seen.segments);
  }
  const GraphSnapshotPtr last = back_end.optimize();
  ASSERT_TRUE(store.flush(seconds(20)));
  write_file(name + ".json", graph_json(*last));
}

TEST(Store, FilesOfEverySchemaAreReadForEver) {
  if (const char* folder = std::getenv("SGRAPH_WRITE_SAMPLE")) write_sample(folder);
  for (int schema = 1; schema <= store_schema; ++schema) {
    const std::string name = samples + ("/schema_" + std::to_string(schema));
    const GraphSnapshot written = parse_graph_json(read_file(name + ".json"));
    EXPECT_TRUE(check_map(name + ".sgmap").empty());
    EXPECT_EQ(summarize_map(name + ".sgmap").schema, schema);
    const StoredMap map = read_map(name + ".sgmap", Clouds::all);
    const GraphSnapshot read = snapshot_of(map);
    ASSERT_EQ(read.keyframes.size(), written.keyframes.size());
    for (const auto& [id, keyframe] : written.keyframes) {
      EXPECT_EQ(read.keyframes.at(id).stamp, keyframe.stamp);
      EXPECT_LT((read.keyframes.at(id).T_map_base.translation - keyframe.T_map_base.translation).norm(), 1e-6);
      ASSERT_NE(read.keyframes.at(id).cloud.get(), nullptr);
      EXPECT_EQ(read.keyframes.at(id).cloud.get()->size(), 40U);
    }
    ASSERT_EQ(read.planes.size(), written.planes.size());
    bool retired = false;
    for (const auto& [id, plane] : written.planes) {
      EXPECT_EQ(read.planes.at(id).plane_class, plane.plane_class);
      EXPECT_LT((read.planes.at(id).plane.normal - plane.plane.normal).norm(), 1e-6);
      EXPECT_NEAR(read.planes.at(id).plane.d, plane.plane.d, 1e-6);
      EXPECT_EQ(read.planes.at(id).keyframes, plane.keyframes);
      KeyframeSet with_views;
      for (const SceneObservation& view : read.planes.at(id).observations) with_views.insert(view.keyframe);
      retired = retired || with_views != plane.keyframes;
    }
    EXPECT_EQ(retired, schema >= 2);  // the sample of the first schema is of a walk without any
    EXPECT_EQ(read.rooms.size(), written.rooms.size());
    EXPECT_EQ(nlohmann::json::parse(read.factors_json).size(), nlohmann::json::parse(written.factors_json).size());
    // It can be gone on with: the file is brought to the present schema.
    const Folder folder;
    std::filesystem::copy_file(name + ".sgmap", folder.file("map.sgmap"));
    std::filesystem::permissions(folder.file("map.sgmap"), std::filesystem::perms::owner_all);
    { MapStore(folder.file("map.sgmap"), MapStore::Mode::extend, session()).write(batch_of(1000)); }
    EXPECT_EQ(summarize_map(folder.file("map.sgmap")).schema, store_schema);
    EXPECT_EQ(summarize_map(folder.file("map.sgmap")).keyframes, static_cast<std::int64_t>(written.keyframes.size()) + 1);
  }
}

std::string error_of(const std::string& path) {
  try {
    read_map(path, Clouds::all);
  } catch (const StoreError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find('\n'), std::string::npos);
    EXPECT_EQ(text.rfind(path, 0), 0U) << text;
    return text.substr(path.size());
  }
  return "no error";
}

TEST(Store, SaysWhatIsWrongWithAFile) {
  const Folder folder;
  EXPECT_EQ(error_of(folder.file("none.sgmap")), ": there is no such file");
  EXPECT_EQ(error_of(folder.path()), ": there is no such file");
  write_file(folder.file("text.sgmap"), std::string(5000, 'x'));
  EXPECT_EQ(error_of(folder.file("text.sgmap")), ": it is no map file, or a damaged one");
  write_file(folder.file("empty.sgmap"), "");
  EXPECT_EQ(error_of(folder.file("empty.sgmap")), ": it is no map file");

  const std::string path = folder.file("map.sgmap");
  {
    MapStore store(path, MapStore::Mode::create, session());
    for (std::int64_t id = 0; id < 40; ++id) store.write(batch_of(id));
  }
  const std::string whole = read_file(path);
  write_file(folder.file("short.sgmap"), whole.substr(0, whole.size() / 2));
  EXPECT_NE(error_of(folder.file("short.sgmap")), "no error");
  EXPECT_THROW(MapStore(folder.file("short.sgmap"), MapStore::Mode::extend, session()), StoreError);

  std::filesystem::copy_file(path, folder.file("newer.sgmap"));
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(folder.file("newer.sgmap").c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "PRAGMA user_version = 99", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_EQ(error_of(folder.file("newer.sgmap")).rfind(": it was written by a newer version", 0), 0U);
  EXPECT_THROW(MapStore(folder.file("newer.sgmap"), MapStore::Mode::extend, session()), StoreError);
  EXPECT_EQ(error_of(path), "no error");
}

TEST(Store, ACopyIsAMap) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  MapStore store(path, MapStore::Mode::create, session());
  for (std::int64_t id = 0; id < 5; ++id) store.write(batch_of(id));
  ASSERT_TRUE(store.flush(seconds(20)));
  copy_map(path, folder.file("copy.sgmap"));
  EXPECT_TRUE(check_map(folder.file("copy.sgmap")).empty());
  EXPECT_EQ(read_map(folder.file("copy.sgmap"), Clouds::all).keyframes.size(), 5U);
  EXPECT_THROW(copy_map(path, "/nowhere/at/all.sgmap"), StoreError);
}

// Bytes overwritten anywhere: read as far as it makes sense, or refused in words; never a crash.
TEST(Store, AScrambledFileIsSurvived) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  {
    MapStore store(path, MapStore::Mode::create, session());
    for (std::int64_t id = 0; id < 30; ++id) store.write(batch_of(id));
  }
  const std::string whole = read_file(path);
  std::mt19937 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    std::string bytes = whole;
    for (int i = 0; i < 30; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    const std::string damaged = folder.file("damaged.sgmap");
    write_file(damaged, bytes);
    try {
      snapshot_of(read_map(damaged, Clouds::all));
      check_map(damaged);
    } catch (const StoreError&) {
    }
    try {
      MapStore store(damaged, MapStore::Mode::extend, session());
      store.write(batch_of(31));
    } catch (const StoreError&) {
    }
    for (const char* part : {"", "-wal", "-shm"}) std::filesystem::remove(damaged + part);
  }
}

// Damaged places cost the places only: they can be found again from the walls.
TEST(Store, ADamagedSceneIsAFaultAndNoMore) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  std::filesystem::copy_file(std::string(samples) + "/schema_1.sgmap", path);
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "UPDATE documents SET value = '{\"format\": 1, \"rooms\": [{}]}' WHERE name = 'scene'", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  const StoredMap map = read_map(path, Clouds::none);
  ASSERT_EQ(map.faults.size(), 1U);
  EXPECT_EQ(map.faults.front().rfind("the places cannot be read", 0), 0U);
  EXPECT_EQ(snapshot_of(map).planes.size(), map.planes.size());
  EXPECT_EQ(check_map(path).size(), 1U);
  EXPECT_EQ(summarize_map(path).rooms, 0);
}

TEST(Store, AFolderThatCannotBeWrittenIsSaid) {
  EXPECT_THROW(MapStore("/proc/map.sgmap", MapStore::Mode::create, session()), StoreError);
  EXPECT_THROW(MapStore("/nowhere/at/all/map.sgmap", MapStore::Mode::create, session()), StoreError);
}

// A file that cannot grow any more, as on a full disk: said once, what was written stays whole, and what waits is written when there is room again.
TEST(Store, AFullDiskLosesNothing) {
  const Folder folder;
  const std::string path = folder.file("map.sgmap");
  { MapStore(path, MapStore::Mode::create, session()).write(batch_of(0)); }
  const pid_t child = fork();
  if (child == 0) {
    // The limit stands for the disk; a signal would end the program otherwise.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{400'000, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::atomic<int> said{0};
    bool good = true;
    {
      MapStore store(path, MapStore::Mode::extend, session(), [&said](const std::string&) { ++said; });
      for (std::int64_t id = 1; id < 400; ++id) store.write(batch_of(id));
      good = good && !store.flush(seconds(20)) && !store.problem().empty();
      limit.rlim_cur = RLIM_INFINITY;
      setrlimit(RLIMIT_FSIZE, &limit);
      good = good && store.flush(seconds(20)) && store.problem().empty();
    }
    good = good && said >= 1;  // it is said on the writer's thread, after flush has its answer
    _exit(good ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_TRUE(check_map(path).empty());
  EXPECT_EQ(read_map(path, Clouds::all).keyframes.size(), 400U);
}

// Killed at any moment, the file opens at once and holds all but the last keyframe and what lies less than a second back.
TEST(Store, SurvivesKillNine) {
  std::mt19937 random(5);
  const char* kills = std::getenv("SGRAPH_KILLS");  // bench/map_store_kills asks for more
  const int trials = kills != nullptr ? std::atoi(kills) : 12;
  for (int trial = 0; trial < trials; ++trial) {
    const Folder folder;
    const std::string path = folder.file("map.sgmap");
    int pipes[2];
    ASSERT_EQ(pipe(pipes), 0);
    const pid_t child = fork();
    if (child == 0) {
      MapStore store(path, MapStore::Mode::create, session());
      for (std::int64_t id = 0;; ++id) {
        store.write(batch_of(id));
        timespec now{};
        clock_gettime(CLOCK_MONOTONIC, &now);
        const std::array<double, 2> record{static_cast<double>(id), static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec)};
        if (write(pipes[1], record.data(), sizeof record) < 0) _exit(1);
        usleep(2000);
      }
    }
    close(pipes[1]);
    usleep(50'000 + static_cast<useconds_t>(random() % 1'200'000));
    kill(child, SIGKILL);
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    const double killed = static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
    waitpid(child, nullptr, 0);
    std::int64_t due = 0;  // keyframes that must be there
    std::array<double, 2> record{};
    while (read(pipes[0], record.data(), sizeof record) == sizeof record) {
      if (record[1] < killed - 1) due = static_cast<std::int64_t>(record[0]);
    }
    close(pipes[0]);
    if (!std::filesystem::exists(path)) continue;  // killed before the file was made
    if (due == 0 && std::filesystem::file_size(path) == 0) continue;
    try {
      EXPECT_TRUE(check_map(path).empty()) << trial;
      EXPECT_GE(static_cast<std::int64_t>(read_map(path, Clouds::all).keyframes.size()), due) << trial;
    } catch (const StoreError& error) {
      EXPECT_EQ(due, 0) << error.what();  // killed while the file was being made
    }
  }
}

}  // namespace
}  // namespace sgraph
