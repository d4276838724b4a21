// The four nodelets in one manager (this process), with taps on the topics between them: what a tap gets must be the publisher's own object.
#include <gtest/gtest.h>
#include <nodelet/loader.h>
#include <ros/ros.h>

#include <mutex>
#include <set>

#include "sgraph_slam/PlaneSegments.h"
#include "sgraph_slam/SceneGraph.h"
#include "sgraph_slam/core/sim/simulator.hpp"
#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"

namespace sgraph {
namespace {

constexpr double limit = 100;  // seconds of real time for the whole chain, on a busy machine

/// Keeps what came on a topic.
class Tap {
 public:
  Tap(ros::NodeHandle& node, const std::string& topic) : subscriber_(node.subscribe<Cloud>(topic, 1000, &Tap::take, this)) {}

  std::vector<CloudMessage> clouds() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return clouds_;
  }

 private:
  void take(const CloudMessage& cloud) {
    const std::lock_guard<std::mutex> lock(mutex_);
    clouds_.push_back(cloud);
  }

  std::mutex mutex_;
  std::vector<CloudMessage> clouds_;
  ros::Subscriber subscriber_;
};

/// The publisher made this very object: only its own pointer carries the std pointer from which it was made.
bool is_the_publishers(const CloudMessage& cloud) {
  const auto* holder = boost::get_deleter<StdOwner<const Cloud>>(cloud);
  return holder && holder->owner.get() == cloud.get();
}

std::set<const Cloud*> addresses(const std::vector<CloudMessage>& clouds) {
  std::set<const Cloud*> result;
  for (const CloudMessage& cloud : clouds) result.insert(cloud.get());
  return result;
}

class ZeroCopy : public testing::Test {
 protected:
  void SetUp() override {
    const std::string base = ros::this_node::getName();  // the parameters are in this test's private namespace: nodelets there find `config`
    for (const auto& [name, type] : std::map<std::string, std::string>{
             {"prefilter", "Prefilter"}, {"odometry", "Odometry"}, {"plane_segmentation", "PlaneSegmentation"}, {"mapping", "Mapping"}})
      ASSERT_TRUE(loader_.load(base + "/" + name, "sgraph_slam/" + type, {}, {})) << type;
    spinner_.start();
  }

  template <class Condition>
  static bool wait_for(Condition condition) {
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(limit);
    while (ros::WallTime::now() < end) {
      if (condition()) return true;
      ros::WallDuration(0.02).sleep();
    }
    return false;
  }

  ros::NodeHandle node_{"~"};
  ros::AsyncSpinner spinner_{1};
  nodelet::Loader loader_{false};
};

TEST_F(ZeroCopy, CloudsPassThroughTheChainAsPointers) {
  Tap filtered(node_, "filtered_points");
  Tap filtered_again(node_, "filtered_points");
  Tap deskewed(node_, "deskewed_points");
  Tap keyframes(node_, "keyframe_points");
  Tap map(node_, "map_points");
  ros::Publisher points = node_.advertise<Cloud>("points", 100);
  ASSERT_TRUE(wait_for([&] { return points.getNumSubscribers() > 0; }));

  const auto simulated = sim::simulate_scans(sim::box_world(8, 6, 2.8, {{-2, 0}, {2, 0}}), 60);
  ASSERT_EQ(simulated.scans.size(), 60U);
  for (std::size_t i = 0; i < simulated.scans.size(); ++i) {
    points.publish(to_boost(simulated.scans[i]));
    // One at a time: here no scan may be dropped, however slow the machine.
    ASSERT_TRUE(wait_for([&] { return deskewed.clouds().size() == i + 1 && filtered_again.clouds().size() == i + 1; })) << "scan " << i;
  }
  ASSERT_TRUE(wait_for([&] { return keyframes.clouds().size() >= 3 && !map.clouds().empty(); }));

  for (Tap* tap : {&filtered, &deskewed, &keyframes, &map})
    for (const CloudMessage& cloud : tap->clouds()) EXPECT_TRUE(is_the_publishers(cloud));
  EXPECT_EQ(addresses(filtered.clouds()), addresses(filtered_again.clouds()));
  EXPECT_EQ(addresses(filtered.clouds()).size(), 60U);
}

TEST_F(ZeroCopy, MappingKeepsThePublishersKeyframeCloud) {
  Tap keyframes(node_, "keyframe_points");
  std::atomic<std::size_t> in_map{0};
  ros::Subscriber graph = node_.subscribe<sgraph_slam::SceneGraph>(
      "graph", 10, [&](const sgraph_slam::SceneGraphConstPtr& message) { in_map = message->keyframes.size(); });
  ros::Publisher points = node_.advertise<Cloud>("points", 100);
  Tap deskewed(node_, "deskewed_points");
  ASSERT_TRUE(wait_for([&] { return points.getNumSubscribers() > 0; }));
  const auto simulated = sim::simulate_scans(sim::box_world(8, 6), 3);
  for (std::size_t i = 0; i < simulated.scans.size(); ++i) {
    points.publish(to_boost(simulated.scans[i]));
    ASSERT_TRUE(wait_for([&] { return deskewed.clouds().size() == i + 1; }));
  }
  ASSERT_TRUE(wait_for([&] { return in_map > 0; }));
  // The first scan is the first keyframe. Who holds it now: the message, this pointer, and the map.
  const CloudPtr cloud = to_std(keyframes.clouds().front());
  EXPECT_TRUE(wait_for([&] { return cloud.use_count() >= 3; })) << cloud.use_count();
}

TEST_F(ZeroCopy, APublisherOutsideTheChainSharesItsObjectToo) {
  std::atomic<std::size_t> planes{0};
  ros::Subscriber subscriber = node_.subscribe<sgraph_slam::PlaneSegments>(
      "planes", 10, [&](const sgraph_slam::PlaneSegmentsConstPtr& message) { planes = message->segments.size(); });
  ros::Publisher keyframe_points = node_.advertise<Cloud>("keyframe_points", 10);
  ASSERT_TRUE(wait_for([&] { return keyframe_points.getNumSubscribers() > 0; }));  // all of one process count as one
  const CloudPtr cloud = sim::simulate_scans(sim::box_world(8, 6), 1).scans.front();
  const long before = cloud.use_count();
  keyframe_points.publish(to_boost(cloud));
  EXPECT_TRUE(wait_for([&] { return planes >= 4; })) << planes;
  // Mapping waits for the keyframe of this cloud and keeps it until then: this very object.
  EXPECT_TRUE(wait_for([&] { return cloud.use_count() > before; }));
}

}  // namespace
}  // namespace sgraph

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "zero_copy_test");
  return RUN_ALL_TESTS();
}
