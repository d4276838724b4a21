#include <std_srvs/Trigger.h>
#include <pluginlib/class_list_macros.hpp>

#include "sgraph_slam/core/segmentation/plane_segmenter.hpp"
#include "sgraph_slam/core/util/stopwatch.hpp"
#include "sgraph_slam/core/util/worker.hpp"
#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/messages.hpp"
#include "sgraph_slam/ros/segment_colors.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"
#include "stage_nodelet.hpp"

namespace sgraph {

/// `keyframe_points` (or any cloud of the package) -> `planes`, `segmented_points`.
class PlaneSegmentationNodelet : public StageNodelet {
 private:
  /// Keyframes aren't dropped. So many clouds wait only where every scan is segmented on a machine that is too slow for it; the memory must end
  /// somewhere.
  static constexpr std::size_t most_waiting = 500;

  void start() override {
    segmenter_.emplace(settings().params.segmentation);
    planes_ = getNodeHandle().advertise<sgraph_slam::PlaneSegments>("planes", 1000);
    segmented_points_ = getNodeHandle().advertise<sensor_msgs::PointCloud2>("segmented_points", 10);
    worker_ = std::make_unique<Worker<CloudPtr>>(
        most_waiting, [this](CloudPtr& cloud, bool) { return segment(*cloud); }, [this](const std::string& text) { health().error(text); });
    flush_ = getMTPrivateNodeHandle().advertiseService("flush", &PlaneSegmentationNodelet::flush, this);
    subscriber_ =
        getNodeHandle().subscribe<Cloud>("keyframe_points", 1000, &PlaneSegmentationNodelet::take, this, ros::TransportHints().tcpNoDelay());
  }

  void take(const CloudMessage& cloud) {
    const std::size_t before = worker_->dropped();
    worker_->push(to_std(cloud));
    health().show("waiting", static_cast<double>(worker_->waiting()));
    if (worker_->dropped() > before) health().error("clouds dropped: they come faster than they can be segmented");
  }

  Work segment(const Cloud& cloud) {
    Stopwatch watch;
    const bool colored = segmented_points_.getNumSubscribers() > 0;
    std::vector<int> labels;
    const PlaneSegments segments = segmenter_->process(cloud, colored ? &labels : nullptr);
    planes_.publish(to_message(segments, cloud.frame));
    health().worked(watch.lap());
    health().show("planes", static_cast<double>(segments.segments.size()));
    if (colored) segmented_points_.publish(colored_cloud(cloud, labels));
    return Work::done;
  }

  bool flush(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    response.success = worker_->drain(service_limit);
    response.message = response.success ? "all clouds that have come are segmented" : "still busy";
    return true;
  }

  std::optional<PlaneSegmenter> segmenter_;
  ros::Publisher planes_;
  ros::Publisher segmented_points_;
  std::unique_ptr<Worker<CloudPtr>> worker_;  // uses what is above; what is below feeds it
  ros::ServiceServer flush_;
  ros::Subscriber subscriber_;
};

}  // namespace sgraph

PLUGINLIB_EXPORT_CLASS(sgraph::PlaneSegmentationNodelet, nodelet::Nodelet)
