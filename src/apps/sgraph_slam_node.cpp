// The four nodelets in one process of their own: clouds pass between them as pointers, and the process ends cleanly at any moment.
#include <nodelet/loader.h>
#include <nodelet/nodelet.h>
#include <pthread.h>
#include <ros/ros.h>
#include <unistd.h>
#include <class_loader/class_loader.hpp>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>
#include <thread>

#include "sgraph_slam/core/util/resources.hpp"
#include "sgraph_slam/ros/master_watch.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"

namespace {

/// Ends the process in order on SIGINT (Ctrl+C, roslaunch) and SIGTERM (service managers). A thread waits for the signals, because a handler may call
/// next to nothing and roscpp's own is polled ten times a second.
class Ending {
 public:
  /// Before any other thread is made: they all inherit that the signals are not theirs.
  Ending() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::thread([this, signals] { wait(signals); }).detach();
  }

  /// From now on the nodelets are taken down one by one. Doesn't return when the end has been asked for already: then the process is ending.
  void started() {
    State loading = State::loading;
    if (state_.compare_exchange_strong(loading, State::running)) return;
    while (true) pause();
  }

 private:
  enum class State { loading, running, ending };

  void wait(const sigset_t& signals) {
    int signal = 0;
    while (sigwait(&signals, &signal) == 0) {
      State loading = State::loading;
      const bool early = state_.compare_exchange_strong(loading, State::ending);
      if (ros::isStarted()) ros::shutdown();
      // While the nodelets are being loaded nothing has been mapped: the master knows that the node is gone, and nothing else would be lost.
      if (early) _exit(0);
    }
  }

  std::atomic<State> state_{State::loading};
};

/// The nodelets' library, wherever it and this program are installed: the build knows the way from one to the other.
std::string library_path() { return (std::filesystem::canonical("/proc/self/exe").parent_path() / SGRAPH_NODELETS).lexically_normal().string(); }

}  // namespace

int main(int argc, char** argv) {
  sgraph::return_freed_memory();
  static Ending ending;  // static: its thread outlives main
  ros::init(argc, argv, "sgraph_slam", ros::init_options::NoSigintHandler);

  // The library is known, so it isn't looked for among all packages, which takes longer than to load it. Before there is a master: what is wrong with
  // the installation is said at once.
  std::unique_ptr<class_loader::ClassLoader> library;
  try {
    library = std::make_unique<class_loader::ClassLoader>(library_path());
  } catch (const class_loader::LibraryLoadException& error) {
    ROS_FATAL_STREAM("the installation is not whole: " << error.what());
    return 1;
  }
  ros::NodeHandle node;
  nodelet::Loader loader([&library](const std::string& type) { return sgraph::to_boost(library->createInstance<nodelet::Nodelet>(type)); });
  const nodelet::M_string remappings(ros::names::getRemappings());
  const std::vector<std::pair<std::string, std::string>> nodelets{// What comes later in the chain subscribes first, so that nothing is missed.
                                                                  {"mapping", "sgraph::MappingNodelet"},
                                                                  {"plane_segmentation", "sgraph::PlaneSegmentationNodelet"},
                                                                  {"odometry", "sgraph::OdometryNodelet"},
                                                                  {"prefilter", "sgraph::PrefilterNodelet"}};
  for (const auto& [name, type] : nodelets) {
    if (!loader.load(ros::names::resolve(name), type, remappings, {})) {
      if (!ros::ok()) break;  // asked to end meanwhile
      ROS_FATAL_STREAM("nodelet " << type << " didn't start");
      return 1;
    }
  }
  ending.started();
  {
    const sgraph::MasterWatch watch;
    ros::spin();
  }
  loader.clear();  // destructors run while ROS is still there
  return 0;
}
