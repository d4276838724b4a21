#include "sgraph_slam/core/pipeline/pipeline.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <stdexcept>

#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/io/map_folder.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph {
namespace {

// The first seconds of a walk in an empty hall, with all sensors.
std::vector<SensorEvent> recording() {
  const sim::World world = sim::box_world(9, 6, 2.8, {{-3, -1}, {2.5, -1}, {2.5, 1.5}});
  sim::SimulationSettings settings;
  settings.duration = 4;
  sim::SimulatedSource source(world, settings);
  std::vector<SensorEvent> events;
  while (auto event = source.next()) events.push_back(*std::move(event));
  return events;
}

const Pose mount{Eigen::Quaterniond::Identity(), {0, 0, 0.5}};

std::string outcome(const Run& run) { return graph_json(*run.snapshot()) + tum_text(run.trajectory()) + tum_text(run.live_trajectory()); }

// Gives the first `count` events, then throws.
NextEvent damaged(const std::vector<SensorEvent>& events, std::size_t count) {
  return [&events, count, i = std::size_t{0}]() mutable -> std::optional<SensorEvent> {
    if (i == count) throw std::runtime_error("damaged");
    return events[i++];
  };
}

NextEvent whole(const std::vector<SensorEvent>& events) {
  return [&events, i = std::size_t{0}]() mutable { return i < events.size() ? std::optional(events[i++]) : std::nullopt; };
}

TEST(Pipeline, StagesBesideEachOtherGiveWhatOneAfterTheOtherDoes) {
  const std::vector<SensorEvent> events = recording();
  Pipeline in_turn(Params(), mount);
  for (const SensorEvent& event : events) {
    if (const auto* odometry = std::get_if<OdometrySample>(&event)) in_turn.add(*odometry);
    if (const auto* imu = std::get_if<ImuSample>(&event)) in_turn.add(*imu);
    if (const auto* scan = std::get_if<CloudPtr>(&event)) in_turn.process(**scan);
  }
  in_turn.finish();
  ASSERT_GE(in_turn.run().snapshot()->planes.size(), 5U);
  for (const std::size_t threads : {1U, 4U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Pipeline beside(Params(), mount);
    std::vector<Stamp> mapped;
    beside.process_all(whole(events), [&](const ScanRecord& record) { mapped.push_back(record.stamp); });
    beside.finish();
    EXPECT_EQ(outcome(beside.run()), outcome(in_turn.run())) << threads;
    ASSERT_EQ(mapped.size(), in_turn.run().records().size());
    for (std::size_t i = 0; i < mapped.size(); ++i) EXPECT_EQ(mapped[i], in_turn.run().records()[i].stamp) << threads;
  }
}

TEST(Pipeline, WhatCameBeforeDamageIsMappedBeforeItIsReported) {
  const std::vector<SensorEvent> events = recording();
  const std::size_t count = events.size() / 2;
  std::size_t scans = 0;
  for (std::size_t i = 0; i < count; ++i) scans += std::holds_alternative<CloudPtr>(events[i]);
  Pipeline pipeline(Params(), mount);
  std::size_t mapped = 0;
  EXPECT_THROW(pipeline.process_all(damaged(events, count), [&](const ScanRecord&) { ++mapped; }), std::runtime_error);
  EXPECT_EQ(mapped, scans);
  pipeline.finish();
  EXPECT_FALSE(pipeline.run().trajectory().empty());
}

TEST(Pipeline, ReadingAheadKeepsTheOrder) {
  const std::vector<SensorEvent> events = recording();
  std::size_t i = 0;
  read_ahead(whole(events), [&](const SensorBatch& batch) {
    for (const SensorEvent& reading : batch.readings) EXPECT_EQ(reading.index(), events.at(i++).index());
    if (batch.scan) {
      EXPECT_EQ(batch.scan, std::get<CloudPtr>(events.at(i++)));
    }
  });
  EXPECT_EQ(i, events.size());
  EXPECT_THROW(read_ahead(whole(events), [](const SensorBatch&) { throw std::logic_error("work"); }), std::logic_error);
}

}  // namespace
}  // namespace sgraph
