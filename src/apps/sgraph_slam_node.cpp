// The four nodelets in one process of their own: clouds pass between them as pointers, and the process ends cleanly at any moment.
#include <nodelet/loader.h>
#include <ros/ros.h>

#include <csignal>

namespace {

/// roscpp handles SIGINT only; service managers send SIGTERM, and the nodelets should see an orderly end then too.
void end(int) { ros::requestShutdown(); }

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "sgraph_slam");
  ros::NodeHandle private_node("~");
  std::signal(SIGTERM, end);

  nodelet::Loader loader(private_node);
  const nodelet::M_string remappings(ros::names::getRemappings());
  const std::vector<std::pair<std::string, std::string>> nodelets{// What comes later in the chain subscribes first, so that nothing is missed.
                                                                  {"mapping", "sgraph_slam/Mapping"},
                                                                  {"plane_segmentation", "sgraph_slam/PlaneSegmentation"},
                                                                  {"odometry", "sgraph_slam/Odometry"},
                                                                  {"prefilter", "sgraph_slam/Prefilter"}};
  for (const auto& [name, type] : nodelets) {
    if (!ros::ok()) return 0;  // asked to end meanwhile
    if (!loader.load(ros::names::resolve(name), type, remappings, {})) {
      if (!ros::ok()) return 0;
      ROS_FATAL_STREAM("nodelet " << type << " didn't start");
      return 1;
    }
  }
  ros::spin();
  loader.clear();  // destructors run while ROS is still there
  return 0;
}
