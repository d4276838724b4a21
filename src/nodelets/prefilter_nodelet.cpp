#include <std_srvs/Trigger.h>
#include <pluginlib/class_list_macros.hpp>

#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/util/stopwatch.hpp"
#include "sgraph_slam/core/util/worker.hpp"
#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"
#include "stage_nodelet.hpp"

namespace sgraph {

/// `points` (any driver's PointCloud2) -> `filtered_points`.
class PrefilterNodelet : public StageNodelet {
 private:
  using Message = sensor_msgs::PointCloud2ConstPtr;

  void start() override {
    health().expect_input();
    prefilter_.emplace(settings().params.prefilter);
    const auto capacity = static_cast<std::size_t>(settings().ros.scan_queue);
    worker_ = std::make_unique<Worker<Message>>(
        capacity, [this](Message& message, bool) { return filter(*message); }, [this](const std::string& text) { health().error(text); });
    publisher_ = getNodeHandle().advertise<Cloud>("filtered_points", 10);
    flush_ = getMTPrivateNodeHandle().advertiseService("flush", &PrefilterNodelet::flush, this);
    subscriber_ =
        getNodeHandle().subscribe<sensor_msgs::PointCloud2>("points", 10, &PrefilterNodelet::take, this, ros::TransportHints().tcpNoDelay());
  }

  void take(const Message& message) {
    const std::size_t before = worker_->dropped();
    worker_->push(message);
    if (worker_->dropped() > before) health().warn("scans dropped: they come faster than they can be filtered");
  }

  Work filter(const sensor_msgs::PointCloud2& message) {
    Stopwatch watch;
    const Converted<CloudPtr> cloud = to_cloud(message);
    if (!cloud) {
      health().count(std::string("scans dropped: ") + to_string(cloud.fault));
      health().error("cloud refused: " + cloud.text);
      return Work::done;
    }
    const std::string frame = settings().ros.lidar_frame.empty() ? cloud.value->frame : settings().ros.lidar_frame;
    if (frame.empty()) {
      health().count("scans dropped: no frame");
      health().error("cloud refused: its header names no frame, and no lidar_frame is given");
      return Work::done;
    }
    const FilteredScan scan = prefilter_->process(*cloud.value);
    publisher_.publish(to_boost(in_frame(scan.cloud, frame)));
    health().worked(watch.lap());
    health().show("points in", scan.counts.input);
    health().show("points out", scan.counts.kept);
    return Work::done;
  }

  static CloudPtr in_frame(const CloudPtr& cloud, const std::string& frame) {
    if (cloud->frame == frame) return cloud;
    auto renamed = std::make_shared<Cloud>(*cloud);
    renamed->frame = frame;
    return renamed;
  }

  bool flush(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    response.success = worker_->drain(service_limit);
    response.message = response.success ? "all scans that have come are filtered" : "still busy";
    return true;
  }

  std::optional<Prefilter> prefilter_;
  ros::Publisher publisher_;
  std::unique_ptr<Worker<Message>> worker_;  // uses what is above; what is below feeds it
  ros::ServiceServer flush_;
  ros::Subscriber subscriber_;
};

}  // namespace sgraph

PLUGINLIB_EXPORT_CLASS(sgraph::PrefilterNodelet, nodelet::Nodelet)
