#include "sgraph_slam/core/util/worker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace sgraph {
namespace {

using namespace std::chrono_literals;
constexpr auto long_enough = 20'000ms;

void unexpected(const std::string& text) { ADD_FAILURE() << text; }

TEST(Worker, DoesEverythingInOrder) {
  std::vector<int> done;
  Worker<int> worker(
      0,
      [&](int& item, bool) {
        done.push_back(item);
        return Work::done;
      },
      unexpected);
  for (int i = 0; i < 1000; ++i) worker.push(i);
  ASSERT_TRUE(worker.drain(long_enough));
  std::vector<int> expected(1000);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(done, expected);
  EXPECT_EQ(worker.dropped(), 0U);
}

TEST(Worker, DropsTheOldestWhenFull) {
  std::promise<void> started;
  std::promise<void> gate;
  std::shared_future<void> open = gate.get_future().share();
  std::vector<int> done;
  Worker<int> worker(
      3,
      [&](int& item, bool) {
        if (item == 0) started.set_value();
        open.wait();
        done.push_back(item);
        return Work::done;
      },
      unexpected);
  worker.push(0);
  started.get_future().wait();  // 0 is in work and takes no place
  for (int i = 1; i <= 6; ++i) worker.push(i);
  EXPECT_EQ(worker.waiting(), 3U);
  EXPECT_EQ(worker.dropped(), 3U);
  gate.set_value();
  ASSERT_TRUE(worker.drain(long_enough));
  EXPECT_EQ(done, (std::vector<int>{0, 4, 5, 6}));
}

TEST(Worker, DropsOnlyWhatMayBeDropped) {
  std::promise<void> started;
  std::promise<void> gate;
  std::shared_future<void> open = gate.get_future().share();
  std::vector<int> done;
  Worker<int> worker(
      2,
      [&](int& item, bool) {
        if (item == 0) started.set_value();
        open.wait();
        done.push_back(item);
        return Work::done;
      },
      unexpected, [](const int& item) { return item > 0; });
  worker.push(0);
  started.get_future().wait();
  for (const int item : {-1, 1, -2, 2, -3, 3, -4, 4}) worker.push(item);
  gate.set_value();
  ASSERT_TRUE(worker.drain(long_enough));
  EXPECT_EQ(done, (std::vector<int>{0, -1, -2, -3, 3, -4, 4}));
  EXPECT_EQ(worker.dropped(), 2U);
}

TEST(Worker, KeepsAnItemThatMustWait) {
  std::atomic<bool> ready{false};
  std::vector<int> done;
  Worker<int> worker(
      0,
      [&](int& item, bool hurry) {
        if (!ready && !hurry) return Work::later;
        done.push_back(item);
        return Work::done;
      },
      unexpected);
  for (int i = 0; i < 5; ++i) worker.push(i);
  EXPECT_EQ(worker.dropped(), 0U);
  ready = true;
  worker.poke();
  ASSERT_TRUE(worker.drain(long_enough));
  EXPECT_EQ(done, (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST(Worker, DrainHurriesWhatWaits) {
  std::vector<int> done;
  Worker<int> worker(
      0,
      [&](int& item, bool hurry) {
        if (!hurry) return Work::later;
        done.push_back(item);
        return Work::done;
      },
      unexpected);
  for (int i = 0; i < 5; ++i) worker.push(i);
  ASSERT_TRUE(worker.drain(long_enough));
  EXPECT_EQ(done, (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST(Worker, BoundsTheQueueBehindAnItemThatMustWait) {
  std::vector<int> done;
  Worker<int> worker(
      4,
      [&](int& item, bool hurry) {
        if (!hurry) return Work::later;
        done.push_back(item);
        return Work::done;
      },
      unexpected);
  for (int i = 0; i < 100; ++i) worker.push(i);
  ASSERT_TRUE(worker.drain(long_enough));
  EXPECT_EQ(done.size() + worker.dropped(), 100U);
  EXPECT_LE(done.size(), 5U);  // four that waited, and one that was in hand
  ASSERT_FALSE(done.empty());
  EXPECT_EQ(done.back(), 99);
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
}

TEST(Worker, GoesOnAfterAnException) {
  std::string text;
  int done = 0;
  Worker<int> worker(
      0,
      [&](int& item, bool) {
        if (item == 1) throw std::runtime_error("no good");
        ++done;
        return Work::done;
      },
      [&](const std::string& what) { text = what; });
  for (int i = 0; i < 3; ++i) worker.push(i);
  ASSERT_TRUE(worker.drain(long_enough));
  EXPECT_EQ(done, 2);
  EXPECT_EQ(text, "no good");
}

TEST(Worker, DrainGivesUp) {
  std::promise<void> gate;
  std::shared_future<void> open = gate.get_future().share();
  Worker<int> worker(
      0,
      [&](int&, bool) {
        open.wait();
        return Work::done;
      },
      unexpected);
  worker.push(0);
  EXPECT_FALSE(worker.drain(1ms));
  gate.set_value();
  EXPECT_TRUE(worker.drain(long_enough));
}

TEST(Worker, EndsWithItemsWaitingAndLetsThemGo) {
  const auto token = std::make_shared<int>(1);
  {
    Worker<std::shared_ptr<int>> worker(
        0, [](std::shared_ptr<int>&, bool) { return Work::later; }, unexpected);
    for (int i = 0; i < 10; ++i) worker.push(token);
  }
  EXPECT_EQ(token.use_count(), 1);
}

TEST(Worker, TakesItemsFromManyThreads) {
  std::atomic<int> sum{0};
  Worker<int> worker(
      0,
      [&](int& item, bool) {
        sum += item;
        return Work::done;
      },
      unexpected);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&worker] {
      for (int i = 0; i < 1000; ++i) worker.push(1);
    });
  for (std::thread& thread : threads) thread.join();
  ASSERT_TRUE(worker.drain(long_enough));
  EXPECT_EQ(sum, 4000);
}

}  // namespace
}  // namespace sgraph
