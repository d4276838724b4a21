#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace sgraph {

/// What a worker's function says about the item it was given.
enum class Work {
  done,
  later,  ///< something else is needed first: keep the item in front and ask again
};

/// A thread that works on items one by one in order of arrival. At most `capacity` items wait (0: any number); when there is no room the oldest
/// waiting one is dropped and counted. All functions may be called from any thread.
template <class Item>
class Worker {
 public:
  /// `work(item, hurry)` runs on the worker's thread; `hurry` asks it not to answer `later` any more, since somebody waits in `drain`. What it throws
  /// ends in `failed(text)`, and the item counts as done.
  using Function = std::function<Work(Item& item, bool hurry)>;

  Worker(
      std::size_t capacity, Function work, std::function<void(const std::string&)> failed,
      std::function<bool(const Item&)> droppable = [](const Item&) { return true; })
      : capacity_(capacity), work_(std::move(work)), failed_(std::move(failed)), droppable_(std::move(droppable)), thread_([this] { run(); }) {}

  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Ends the thread after the item at hand; items that still wait are let go.
  ~Worker() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  void push(Item item) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (droppable_(item) && full()) {
        items_.erase(std::find_if(items_.begin(), items_.end(), droppable_));
        ++dropped_;
      }
      items_.push_back(std::move(item));
    }
    changed_.notify_all();
  }

  /// Asks a function that answered `later` again at once.
  void poke() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      poked_ = true;
    }
    changed_.notify_all();
  }

  /// Waits until nothing waits and nothing is being worked on; false when it takes longer than `limit`.
  bool drain(std::chrono::milliseconds limit) {
    std::unique_lock<std::mutex> lock(mutex_);
    ++hurried_;
    changed_.notify_all();
    const bool empty = changed_.wait_for(lock, limit, [this] { return stop_ || (items_.empty() && !busy_); });
    --hurried_;
    return empty && !stop_;
  }

  /// Items that wait, the one being worked on not counted.
  [[nodiscard]] std::size_t waiting() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return items_.size();
  }

  [[nodiscard]] std::size_t dropped() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return dropped_;
  }

 private:
  void run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stop_ || !items_.empty(); });
      if (stop_) return;
      Item item = std::move(items_.front());
      items_.pop_front();
      busy_ = true;
      poked_ = false;
      const bool hurry = hurried_ > 0;
      lock.unlock();
      const Work result = attempt(item, hurry);
      lock.lock();
      busy_ = false;
      if (result == Work::later && !hurry) put_back(lock, std::move(item));
      changed_.notify_all();
    }
  }

  Work attempt(Item& item, bool hurry) {
    try {
      return work_(item, hurry);
    } catch (const std::exception& error) {
      failed_(error.what());
    } catch (...) {
      failed_("unknown exception");
    }
    return Work::done;
  }

  [[nodiscard]] bool full() const {
    return capacity_ > 0 && static_cast<std::size_t>(std::count_if(items_.begin(), items_.end(), droppable_)) >= capacity_;
  }

  /// Puts the item back in front and waits for a change. Where newer items have filled the queue in the meantime, the item is the one to drop.
  void put_back(std::unique_lock<std::mutex>& lock, Item item) {
    if (droppable_(item) && full()) {
      ++dropped_;
      return;
    }
    items_.push_front(std::move(item));
    const std::size_t size = items_.size();
    changed_.wait_for(lock, std::chrono::milliseconds(50), [&] { return stop_ || poked_ || hurried_ > 0 || items_.size() > size; });
  }

  const std::size_t capacity_;
  const Function work_;
  const std::function<void(const std::string&)> failed_;
  const std::function<bool(const Item&)> droppable_;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  std::deque<Item> items_;
  std::size_t dropped_ = 0;
  bool busy_ = false;
  bool poked_ = false;
  bool stop_ = false;
  int hurried_ = 0;  // callers of drain

  std::thread thread_;  // last: it uses all of the above
};

}  // namespace sgraph
