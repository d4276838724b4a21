#include "sgraph_slam/core/io/temporary_clouds.hpp"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <random>
#include <thread>

namespace sgraph {
namespace {

CloudPtr random_cloud(unsigned seed, std::size_t points) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0, 10);
  auto cloud = std::make_shared<Cloud>();
  cloud->stamp.nanoseconds = 1'700'000'000'000'000'000 + seed;
  cloud->frame = seed % 2 == 0 ? "velodyne" : "";
  for (std::size_t i = 0; i < points; ++i)
    cloud->points.push_back({normal(random), normal(random), normal(random), normal(random), normal(random), static_cast<std::uint16_t>(i)});
  for (unsigned i = 0; i < seed % 4; ++i) cloud->viewpoints.push_back({0.1 * i, {normal(random), normal(random), normal(random)}});
  return cloud;
}

void expect_same(const Cloud& a, const Cloud& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.frame, b.frame);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.points[i].position(), b.points[i].position());
    EXPECT_EQ(a.points[i].intensity, b.points[i].intensity);
    EXPECT_EQ(a.points[i].time, b.points[i].time);
    EXPECT_EQ(a.points[i].ring, b.points[i].ring);
  }
  ASSERT_EQ(a.viewpoints.size(), b.viewpoints.size());
  for (std::size_t i = 0; i < a.viewpoints.size(); ++i) {
    EXPECT_EQ(a.viewpoints[i].time, b.viewpoints[i].time);
    EXPECT_EQ(a.viewpoints[i].position, b.viewpoints[i].position);
  }
}

TEST(TemporaryClouds, GivesBackEveryCloudAsItWasAndKeepsOnlyAFewInMemory) {
  TemporaryClouds clouds({}, 4);
  for (unsigned k = 0; k < 40; ++k) clouds.put({k}, random_cloud(k, 17 * k));
  EXPECT_EQ(clouds.in_memory(), 4U);
  for (unsigned k = 0; k < 40; ++k) {
    const CloudPtr cloud = clouds.get({(7 * k) % 40});
    ASSERT_TRUE(cloud);
    expect_same(*cloud, *random_cloud((7 * k) % 40, 17 * ((7 * k) % 40)));
  }
  EXPECT_EQ(clouds.in_memory(), 4U);
  EXPECT_EQ(clouds.failure(), "");
  EXPECT_EQ(clouds.get({99}), nullptr);
  clouds.put({3}, random_cloud(5, 10));  // another in its place
  expect_same(*clouds.get({3}), *random_cloud(5, 10));
  clouds.put({3}, nullptr);
  EXPECT_EQ(clouds.get({3}), nullptr);
}

TEST(TemporaryClouds, LosesNothingWhereNoFileCanBeMade) {
  TemporaryClouds clouds("/proc/no/such/folder", 2);
  EXPECT_NE(clouds.failure(), "");
  for (unsigned k = 0; k < 5; ++k) clouds.put({k}, random_cloud(k, 10));
  for (unsigned k = 0; k < 5; ++k) expect_same(*clouds.get({k}), *random_cloud(k, 10));
}

TEST(TemporaryClouds, LosesNothingWhenTheFileCannotGrow) {
  TemporaryClouds clouds({}, 2);
  // A limit on the size of files stands for a full disk: writing fails half-way.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{10'000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  for (unsigned k = 0; k < 6; ++k) clouds.put({k}, random_cloud(k, 150));
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(clouds.failure(), "");
  for (unsigned k = 0; k < 6; ++k) expect_same(*clouds.get({k}), *random_cloud(k, 150));
}

TEST(TemporaryClouds, LeavesNoFileBehindInItsFolder) {
  const auto folder = std::filesystem::temp_directory_path() / "sgraph_temporary_clouds_test";
  std::filesystem::create_directories(folder);
  {
    TemporaryClouds clouds(folder.string());
    clouds.put({1}, random_cloud(1, 1000));
    EXPECT_TRUE(std::filesystem::is_empty(folder));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove_all(folder);
}

TEST(TemporaryClouds, ManyThreadsReadWhileOneWrites) {
  TemporaryClouds clouds({}, 3);
  for (unsigned k = 0; k < 20; ++k) clouds.put({k}, random_cloud(k, 200));
  std::vector<std::thread> readers;
  std::vector<int> wrong(3, 0);
  for (unsigned r = 0; r < 3; ++r) {
    readers.emplace_back([&clouds, &wrong, r] {
      for (unsigned i = 0; i < 200; ++i) {
        const unsigned k = (i * (r + 3)) % 20;
        const CloudPtr cloud = clouds.get({k});
        if (!cloud || cloud->stamp.nanoseconds != 1'700'000'000'000'000'000 + k || cloud->size() != 200) ++wrong[r];
      }
    });
  }
  for (unsigned k = 20; k < 100; ++k) clouds.put({k}, random_cloud(k, 200));
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, std::vector<int>(3, 0));
}

}  // namespace
}  // namespace sgraph
