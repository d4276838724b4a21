#include "sgraph_slam/core/sensor/sensor_adapter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/spinning_lidar.hpp"

namespace sgraph {
namespace {

using test::SpinningLidar;

constexpr double start = 1'600'000'000;

RawScan raw_of(const Cloud& cloud, const std::string& time_field = "", double scale = 1, double offset = 0) {
  RawScan raw;
  raw.cloud = cloud;
  raw.has_ring = true;
  raw.has_intensity = true;
  raw.time_field = time_field;
  raw.received = cloud.stamp.after(0.005);
  for (Point& p : raw.cloud.points) {
    if (!time_field.empty()) raw.times.push_back(scale * (static_cast<double>(p.time) + offset));
    p.time = 0;
  }
  return raw;
}

// What the adapter makes of ten turns, the first being of number 0.
std::vector<CloudPtr> adapted(SensorAdapter& adapter, const SpinningLidar& lidar, const std::function<RawScan(Cloud)>& convention) {
  std::vector<CloudPtr> scans;
  for (int i = 0; i < 10; ++i) {
    AdaptedScans one = adapter.take(convention(lidar.scan(start + lidar.turn * i)));
    EXPECT_EQ(one.fault, RawFault::none) << one.text;
    scans.insert(scans.end(), one.scans.begin(), one.scans.end());
  }
  const AdaptedScans rest = adapter.flush();
  scans.insert(scans.end(), rest.scans.begin(), rest.scans.end());
  return scans;
}

void expect_native(const std::vector<CloudPtr>& scans, const SpinningLidar& lidar, double tolerance, double later = 0) {
  ASSERT_EQ(scans.size(), 10U);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const Cloud truth = lidar.scan(start + lidar.turn * static_cast<double>(k));
    ASSERT_EQ(scans[k]->size(), truth.size());
    double worst = 0;
    int wrong_rings = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double here = (scans[k]->stamp - truth.stamp) + static_cast<double>(scans[k]->points[i].time);
      worst = std::max(worst, std::abs(here - static_cast<double>(truth.points[i].time) - later));
      wrong_rings += scans[k]->points[i].ring != truth.points[i].ring;
    }
    EXPECT_LT(worst, tolerance);
    EXPECT_EQ(wrong_rings, 0);
  }
}

TEST(SensorAdapter, UnitsAndOriginsOfTimeFields) {
  const SpinningLidar lidar;
  struct Case {
    const char* field;
    double scale, offset;
    bool integers;
    const char* unit;
    const char* stamp;
  };
  const std::vector<Case> cases{
      {"time", 1, 0, false, "s", "last"},   {"time", 1, 0.1, false, "s", "first"},    {"time", 1, 0.04, false, "s", "inside"},
      {"t", 1e9, 0.1, true, "ns", "first"}, {"time", 1e6, 0.1, false, "us", "first"}, {"time", 1e3, 0.1, false, "ms", "first"},
      {"t", 1, 0.1, false, "s", "first"},   {"t", 1e6, 0.1, true, "us", "first"},     {"time", 1e9, 0, false, "ns", "last"}};
  for (const Case& c : cases) {
    SensorAdapter adapter({});
    const auto scans = adapted(adapter, lidar, [&](const Cloud& cloud) {
      RawScan raw = raw_of(cloud, c.field, c.scale, c.offset);
      raw.integer_times = c.integers;
      if (c.integers) {
        for (double& t : raw.times) t = std::round(t);
      }
      raw.cloud.stamp = raw.cloud.stamp.after(-c.offset);
      return raw;
    });
    expect_native(scans, lidar, 1e-5);
    EXPECT_EQ(adapter.description().time_unit, c.unit);
    EXPECT_EQ(adapter.description().stamp, c.stamp);
    EXPECT_EQ(adapter.description().time_source, std::string("field ") + c.field);
  }
}

TEST(SensorAdapter, AbsoluteTimesInAnyUnit) {
  const SpinningLidar lidar;
  for (const double scale : {1.0, 1e3, 1e6, 1e9}) {
    SensorAdapter adapter({});
    const auto scans = adapted(adapter, lidar, [&](const Cloud& cloud) { return raw_of(cloud, "timestamp", scale, cloud.stamp.seconds()); });
    expect_native(scans, lidar, 1e-5);
    EXPECT_EQ(adapter.description().time_origin, "absolute");
  }
}

TEST(SensorAdapter, AClockOfItsOwn) {
  const SpinningLidar lidar;
  SensorAdapter adapter({});
  expect_native(adapted(adapter, lidar, [&](const Cloud& cloud) { return raw_of(cloud, "timestamp", 1, cloud.stamp.seconds() - start + 4000); }),
                lidar, 1e-4);
  EXPECT_EQ(adapter.description().time_origin, "on the sensor's own clock");
}

TEST(SensorAdapter, TimesThatCountBackwards) {
  const SpinningLidar lidar;
  SensorAdapter adapter({});
  expect_native(adapted(adapter, lidar, [](const Cloud& cloud) { return raw_of(cloud, "time", -1); }), lidar, 1e-6);
}

TEST(SensorAdapter, TimeFromTheAzimuth) {
  for (const bool clockwise : {true, false}) {
    for (const double begin : {0.0, 100.0, -179.9}) {
      SpinningLidar lidar;
      lidar.clockwise = clockwise;
      lidar.begin_deg = begin;
      SensorAdapter adapter({});
      expect_native(adapted(adapter, lidar, [](const Cloud& cloud) { return raw_of(cloud); }), lidar, 1e-4);
      EXPECT_EQ(adapter.description().sweep, clockwise ? "clockwise" : "counterclockwise");
      EXPECT_EQ(adapter.description().time_source, "azimuth");
      EXPECT_NEAR(adapter.description().turn, 0.1, 1e-6);
      EXPECT_EQ(adapter.description().stamp, "last");
    }
  }
}

// Clouds that are always received more than a turn after their stamps bear the stamp of their first firing.
TEST(SensorAdapter, StampOfTheFirstFiringShowsInTheDelay) {
  const SpinningLidar lidar;
  SensorAdapter adapter({});
  expect_native(adapted(adapter, lidar,
                        [](const Cloud& cloud) {
                          RawScan raw = raw_of(cloud);
                          raw.cloud.stamp = raw.cloud.stamp.after(-0.1);
                          return raw;
                        }),
                lidar, 2e-4);
  EXPECT_EQ(adapter.description().stamp, "first");
}

TEST(SensorAdapter, RingFromTheElevation) {
  SpinningLidar lidar;
  for (const bool offsets : {false, true}) {
    if (offsets) {
      for (const double e : lidar.elevations_deg) lidar.vertical_offsets.push_back(-0.0419 * std::tan(e * M_PI / 180));
    }
    SensorAdapter adapter({});
    expect_native(adapted(adapter, lidar,
                          [](Cloud cloud) {
                            RawScan raw = raw_of(cloud, "time");
                            for (Point& p : raw.cloud.points) p.ring = 0;
                            raw.has_ring = false;
                            return raw;
                          }),
                  lidar, 1e-6);
    EXPECT_EQ(adapter.description().model, "VLP-16");
    EXPECT_EQ(adapter.description().ring_source, "elevation");
    EXPECT_EQ(adapter.description().vertical_offsets, offsets ? "applied" : "absent");
  }
}

TEST(SensorAdapter, SlicesAreJoinedToTurns) {
  for (const bool with_times : {true, false}) {
    SpinningLidar lidar;
    SensorAdapter adapter({});
    std::vector<CloudPtr> scans;
    std::size_t points = 0;
    for (int i = 0; i < 10; ++i) {
      const Cloud turn = lidar.scan(start + 0.1 * i);
      points = turn.size();
      for (std::size_t slice = 0; slice < 12; ++slice) {
        Cloud part = turn;
        part.points.assign(turn.points.begin() + static_cast<std::ptrdiff_t>(slice * points / 12),
                           turn.points.begin() + static_cast<std::ptrdiff_t>((slice + 1) * points / 12));
        const double end = static_cast<double>(part.points.back().time);
        part.stamp = turn.stamp.after(end);
        RawScan raw = raw_of(part, with_times ? "time" : "", 1, -end);
        if (!with_times) {
          raw.has_ring = false;
          for (Point& p : raw.cloud.points) p.ring = 0;
        }
        const AdaptedScans one = adapter.take(std::move(raw));
        scans.insert(scans.end(), one.scans.begin(), one.scans.end());
      }
    }
    EXPECT_TRUE(adapter.description().slices);
    EXPECT_NEAR(adapter.description().turn, 0.1, 5e-4);
    ASSERT_GE(scans.size(), 9U);
    for (const CloudPtr& scan : scans) {
      EXPECT_NEAR(static_cast<double>(scan->size()), static_cast<double>(points), 0.1 * static_cast<double>(points));
      // Every point has the time it was seen at, wherever the turn was cut.
      double worst = 0;
      for (const Point& p : scan->points) {
        const double azimuth = -std::atan2(p.y, p.x);
        const double phase = azimuth / (2 * M_PI) * 0.1;
        worst = std::max(worst, std::abs(std::remainder((scan->stamp.after(static_cast<double>(p.time)) - Stamp::from_seconds(start)) - phase, 0.1)));
      }
      EXPECT_LT(worst, 3e-4);
    }
  }
}

TEST(SensorAdapter, WhatNobodyKnowsStaysUnknown) {
  // All at one moment, as motion-compensated clouds are.
  const SpinningLidar lidar;
  SensorAdapter compensated({});
  auto scans = adapted(compensated, lidar, [](const Cloud& cloud) { return raw_of(cloud, "time", 0); });
  for (const CloudPtr& scan : scans) EXPECT_EQ(scan->points[100].time, 0);
  EXPECT_EQ(compensated.description().time_source, "none");

  // Points in no order.
  SensorAdapter shuffled({});
  scans = adapted(shuffled, lidar, [](Cloud cloud) {
    for (std::size_t i = 0; i < cloud.size(); ++i) std::swap(cloud.points[i], cloud.points[(i * 7919) % cloud.size()]);
    return raw_of(cloud);
  });
  for (const CloudPtr& scan : scans) EXPECT_EQ(scan->points[100].time, 0);

  // Points that somebody has moved since are not as the sensor saw them.
  SensorAdapter moved({});
  scans = adapted(moved, lidar, [](Cloud cloud) {
    for (Point& p : cloud.points) p.set_position(p.position() + Eigen::Vector3f(p.time, 0, 2 * p.time));
    return raw_of(cloud);
  });
  for (const CloudPtr& scan : scans) EXPECT_EQ(scan->points[100].time, 0);
}

TEST(SensorAdapter, ParametersOverrideGuesses) {
  const SpinningLidar lidar;
  SensorParams params;
  params.times = "none";
  SensorAdapter none(params);
  EXPECT_EQ(adapted(none, lidar, [](const Cloud& cloud) { return raw_of(cloud, "time"); }).front()->points[0].time, 0);

  params = {};
  params.times = "azimuth";
  params.stamp = "first";
  params.rate = 20;
  SensorAdapter azimuth(params);
  const auto scans = adapted(azimuth, lidar, [](const Cloud& cloud) { return raw_of(cloud, "time", 0); });
  EXPECT_EQ(scans.front()->points.front().time, 0);
  EXPECT_NEAR(scans.front()->points.back().time, 0.05, 1e-4);
}

TEST(SensorAdapter, ACloudThatLiesOnNoBeamIsRefused) {
  const SpinningLidar lidar;
  SensorAdapter adapter({});
  adapter.take(raw_of(lidar.scan(start), "time"));
  RawScan lies = raw_of(lidar.scan(start + 0.1), "time");
  for (Point& p : lies.cloud.points) std::swap(p.x, p.z);
  EXPECT_EQ(adapter.take(lies).fault, RawFault::beams);
  EXPECT_EQ(adapter.take(raw_of(lidar.scan(start + 0.2), "time")).scans.size(), 1U);

  // Times of a unit of their own in one cloud.
  EXPECT_EQ(adapter.take(raw_of(lidar.scan(start + 0.3), "time", 1e6)).fault, RawFault::times);
}

TEST(SensorAdapter, CloudsThatShowNothingPass) {
  SensorAdapter adapter({});
  RawScan empty;
  EXPECT_EQ(adapter.take(empty).scans.size(), 1U);
  EXPECT_FALSE(adapter.decided());
}

TEST(SensorAdapter, NativeScansPassAtOnce) {
  const SpinningLidar lidar;
  SensorAdapter adapter({});
  EXPECT_EQ(adapter.take(raw_of(lidar.scan(start), "time")).scans.size(), 1U);
  EXPECT_TRUE(adapter.decided());
}

}  // namespace
}  // namespace sgraph
