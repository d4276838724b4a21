#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sgraph {

/// Makes a master that was started again know this node: topics and services of the process are registered with it as they were with the one before.
/// roscpp registers each of them once, when it is made, so that otherwise nobody new could find the node, neither a driver that was started again nor
/// rviz. What is connected stays connected. Parameters are the master's and gone with it; the node has read its own.
///
/// A thread of its own asks the master once a second whether it knows the node. While there is no master nothing happens.
class MasterWatch {
 public:
  /// When topics and services have been made: services that are made later are not registered again (topics are).
  MasterWatch();
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

 private:
  void run();

  const std::vector<std::string> services_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace sgraph
