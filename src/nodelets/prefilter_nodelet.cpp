#include <std_srvs/Trigger.h>
#include <pluginlib/class_list_macros.hpp>

#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/sensor/sensor_adapter.hpp"
#include "sgraph_slam/core/sensor/stamp_filter.hpp"
#include "sgraph_slam/core/util/stopwatch.hpp"
#include "sgraph_slam/core/util/worker.hpp"
#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"
#include "sgraph_slam/ros/velodyne_scan.hpp"
#include "stage_nodelet.hpp"

namespace sgraph {

/// `points` (any driver's PointCloud2) or `packets` (velodyne_msgs/VelodyneScan) -> `filtered_points`.
class PrefilterNodelet : public StageNodelet {
 private:
  struct Message {
    sensor_msgs::PointCloud2ConstPtr cloud;  // one of the two; neither: hand out what is held
    VelodyneScanConstPtr packets;
    ros::Time received;
  };

  void start() override {
    health().expect_input();
    adapter_.emplace(settings().params.sensor);
    prefilter_.emplace(settings().params.prefilter);
    const auto capacity = static_cast<std::size_t>(settings().ros.scan_queue);
    worker_ = std::make_unique<Worker<Message>>(
        capacity, [this](Message& message, bool) { return take_message(message); }, [this](const std::string& text) { health().error(text); });
    publisher_ = getNodeHandle().advertise<Cloud>("filtered_points", 10);
    flush_ = getMTPrivateNodeHandle().advertiseService("flush", &PrefilterNodelet::flush, this);
    const auto hints = ros::TransportHints().tcpNoDelay();
    subscriber_ = getNodeHandle().subscribe<sensor_msgs::PointCloud2>(
        "points", 10,
        [this](const sensor_msgs::PointCloud2ConstPtr& cloud) {
          push({cloud, nullptr, ros::Time::now()});
        },
        ros::VoidConstPtr(), hints);
    packets_ = getNodeHandle().subscribe<VelodyneScanMessage>(
        "packets", 10,
        [this](const VelodyneScanConstPtr& packets) {
          push({nullptr, packets, ros::Time::now()});
        },
        ros::VoidConstPtr(), hints);
  }

  void push(const Message& message) {
    const std::size_t before = worker_->dropped();
    worker_->push(message);
    if (worker_->dropped() > before) health().warn("scans dropped: they come faster than they can be filtered");
  }

  Work take_message(const Message& message) {
    if (!message.cloud && !message.packets) {
      take_adapted([this] { return adapter_->flush(); }, std::nullopt);
      return Work::done;
    }
    // Without a clock, as before the first message of a simulated one, nothing is known about delays.
    const auto received = message.received.isZero() ? std::nullopt : std::make_optional(message.received);
    Converted<RawScan> raw = message.cloud ? to_raw_scan(*message.cloud, received) : to_raw_scan(*message.packets, true, received);
    if (!raw) {
      refuse(to_string(raw.fault), raw.text);
      return Work::done;
    }
    const std::string frame = settings().ros.lidar_frame.empty() ? raw.value.cloud.frame : settings().ros.lidar_frame;
    if (frame.empty()) {
      refuse("no frame", "its header names no frame, and no lidar_frame is given");
      return Work::done;
    }
    raw.value.cloud.frame = frame;
    take_adapted([&] { return adapter_->take(std::move(raw.value)); }, received ? std::make_optional(to_stamp(*received)) : std::nullopt);
    return Work::done;
  }

  template <class Adapt>
  void take_adapted(Adapt adapt, const std::optional<Stamp>& received) {
    const bool decided = adapter_->decided();
    const AdaptedScans adapted = adapt();
    if (!decided && adapter_->decided()) {
      const std::string text = adapter_->description().text();
      NODELET_INFO_STREAM(text);
      health().show("sensor", text);
    }
    filter(adapted, received);
  }

  void refuse(const std::string& reason, const std::string& text) {
    health().count("scans dropped: " + reason);
    health().error("cloud refused: " + text);
  }

  void filter(const AdaptedScans& adapted, const std::optional<Stamp>& received) {
    if (adapted.fault != RawFault::none)
      refuse(to_string(adapted.fault == RawFault::times ? MessageFault::times : MessageFault::beams), adapted.text);
    for (const CloudPtr& whole : adapted.scans) {
      for (const CloudPtr& cloud : stamps_.push(whole, received)) filter(*cloud);
    }
    if (stamps_.dropped() > stamps_dropped_) {
      for (; stamps_dropped_ < stamps_.dropped(); ++stamps_dropped_) health().count("scans dropped: stamp");
      health().error("cloud refused: its stamp is far ahead of those before and after it");
    }
  }

  void filter(const Cloud& cloud) {
    Stopwatch watch;
    const FilteredScan scan = prefilter_->process(cloud);
    publisher_.publish(to_boost(scan.cloud));
    health().worked(watch.lap());
    health().show("points in", scan.counts.input);
    health().show("points out", scan.counts.kept);
  }

  bool flush(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    push({});
    response.success = worker_->drain(service_limit);
    response.message = response.success ? "all scans that have come are filtered" : "still busy";
    return true;
  }

  std::optional<SensorAdapter> adapter_;
  StampFilter stamps_{StampFilter::Backward::passes};
  int stamps_dropped_ = 0;
  std::optional<Prefilter> prefilter_;
  ros::Publisher publisher_;
  std::unique_ptr<Worker<Message>> worker_;  // uses what is above; what is below feeds it
  ros::ServiceServer flush_;
  ros::Subscriber subscriber_;
  ros::Subscriber packets_;
};

}  // namespace sgraph

PLUGINLIB_EXPORT_CLASS(sgraph::PrefilterNodelet, nodelet::Nodelet)
