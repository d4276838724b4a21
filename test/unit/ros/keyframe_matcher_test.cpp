#include "sgraph_slam/ros/keyframe_matcher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace sgraph {
namespace {

ReceivedKeyframe keyframe_at(std::int64_t id, std::int64_t nanoseconds) {
  ReceivedKeyframe received;
  received.keyframe.id = {id};
  received.keyframe.stamp = {nanoseconds};
  return received;
}

CloudPtr cloud_at(std::int64_t nanoseconds) {
  auto cloud = std::make_shared<Cloud>();
  cloud->stamp = {nanoseconds};
  return cloud;
}

PlaneSegments planes_at(std::int64_t nanoseconds) {
  PlaneSegments segments;
  segments.stamp = {nanoseconds};
  return segments;
}

std::vector<std::int64_t> ids(const std::vector<MatchedKeyframe>& matched) {
  std::vector<std::int64_t> result;
  for (const MatchedKeyframe& m : matched) {
    EXPECT_EQ(m.received.keyframe.cloud->stamp, m.received.keyframe.stamp);
    EXPECT_EQ(m.segments.stamp, m.received.keyframe.stamp);
    result.push_back(m.received.keyframe.id.value);
  }
  return result;
}

using Ids = std::vector<std::int64_t>;

TEST(KeyframeMatcher, MatchesByExactStampInOrder) {
  KeyframeMatcher matcher(3);
  matcher.add(cloud_at(100));
  matcher.add(keyframe_at(0, 100));
  EXPECT_TRUE(matcher.take().empty());
  matcher.add(planes_at(101));  // a nanosecond off: another scan
  EXPECT_TRUE(matcher.take().empty());
  const CloudPtr cloud = cloud_at(100);
  matcher.add(cloud);
  matcher.add(planes_at(100));
  const auto matched = matcher.take();
  EXPECT_EQ(ids(matched), Ids{0});
  EXPECT_EQ(matched[0].received.keyframe.cloud, cloud);
  EXPECT_TRUE(matcher.take().empty());
}

TEST(KeyframeMatcher, ComesOutInOrderWhateverTheOrderOfArrival) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const int size = 10;
    std::vector<int> arrivals(3 * size);
    for (int i = 0; i < 3 * size; ++i) arrivals[static_cast<std::size_t>(i)] = i;
    std::shuffle(arrivals.begin(), arrivals.end(), std::mt19937(seed));
    KeyframeMatcher matcher(1000);
    Ids out;
    std::int64_t next_keyframe = 0;  // on its topic each comes after the one before
    for (const int arrival : arrivals) {
      const std::int64_t id = arrival / 3;
      if (arrival % 3 == 0) matcher.add(cloud_at(100 + id));
      if (arrival % 3 == 1) matcher.add(planes_at(100 + id));
      if (arrival % 3 == 2) {
        matcher.add(keyframe_at(next_keyframe, 100 + next_keyframe));
        ++next_keyframe;
      }
      for (const std::int64_t taken : ids(matcher.take())) out.push_back(taken);
    }
    EXPECT_EQ(out, (Ids{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_EQ(matcher.incomplete(), 0U);
  }
}

TEST(KeyframeMatcher, GivesUpWhenAPartIsLost) {
  KeyframeMatcher matcher(2);
  matcher.add(keyframe_at(0, 100));
  matcher.add(cloud_at(100));  // its planes never come
  for (std::int64_t id = 1; id <= 2; ++id) {
    matcher.add(keyframe_at(id, 100 + id));
    matcher.add(cloud_at(100 + id));
    matcher.add(planes_at(100 + id));
    EXPECT_TRUE(matcher.take().empty());
  }
  EXPECT_EQ(matcher.waiting(), 3U);
  matcher.add(keyframe_at(3, 103));
  matcher.add(cloud_at(103));
  matcher.add(planes_at(103));
  EXPECT_EQ(ids(matcher.take()), (Ids{1, 2, 3}));
  EXPECT_EQ(matcher.incomplete(), 1U);
  EXPECT_EQ(matcher.waiting(), 0U);
}

TEST(KeyframeMatcher, PlanesOfEveryScanDoNotHoldBackKeyframes) {
  KeyframeMatcher matcher(2);
  for (std::int64_t t = 0; t < 1000; ++t) matcher.add(planes_at(t));
  matcher.add(keyframe_at(0, 990));
  matcher.add(cloud_at(990));
  EXPECT_EQ(ids(matcher.take()), Ids{0});
  EXPECT_EQ(matcher.incomplete(), 0U);
}

TEST(KeyframeMatcher, StartsAnewWhenTimeGoesBack) {
  KeyframeMatcher matcher(2);
  for (std::int64_t id = 0; id < 3; ++id) {
    matcher.add(keyframe_at(id, 1000 + id));
    matcher.add(cloud_at(1000 + id));
    matcher.add(planes_at(1000 + id));
  }
  EXPECT_EQ(ids(matcher.take()).size(), 3U);
  matcher.add(keyframe_at(3, 1003));  // waits for its parts when the bag starts again
  EXPECT_TRUE(matcher.take().empty());
  matcher.add(cloud_at(10));
  matcher.add(keyframe_at(0, 10));
  matcher.add(planes_at(10));
  EXPECT_EQ(ids(matcher.take()), Ids{0});
  matcher.add(keyframe_at(1, 11));
  matcher.add(cloud_at(11));
  matcher.add(planes_at(11));
  EXPECT_EQ(ids(matcher.take()), Ids{1});
}

}  // namespace
}  // namespace sgraph
