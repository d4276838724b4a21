#include "bag_files.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "sgraph_slam/ros/conversions.hpp"

namespace sgraph {
namespace {

// Throws unless the file looks like a bag.
void check_file(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const auto status = fs::status(path, error);
  if (!fs::exists(status)) throw std::runtime_error(path + ": there is no such file");
  if (fs::is_directory(status)) throw std::runtime_error(path + ": is a folder, not a bag");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": can't be read (permissions?)");
  std::string magic(8, '\0');
  file.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  if (file.gcount() == 0) throw std::runtime_error(path + ": the file is empty (0 bytes)");
  if (magic != "#ROSBAG ") throw std::runtime_error(path + ": is not a ROS bag");
}

}  // namespace

std::string BagFiles::damaged(const std::string& what, const std::string& why) {
  return what + ": the bag is truncated, damaged or was not closed (" + why + "); `rosbag reindex` may rescue what it holds";
}

BagFiles::BagFiles(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    names_ += (names_.empty() ? "" : ", ") + path;
    check_file(path);
    guarded(path, [&] {
      bags_.push_back(std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read));
      for (const rosbag::ConnectionInfo* connection : rosbag::View(*bags_.back()).getConnections()) types_[connection->topic] = connection->datatype;
    });
  }
  if (types_.empty()) throw std::runtime_error(names_ + ": holds no messages");
}

void BagFiles::require(const std::string& topic, const std::vector<std::string>& datatypes) const {
  const auto fits = [&datatypes](const std::string& type) { return std::find(datatypes.begin(), datatypes.end(), type) != datatypes.end(); };
  const auto found = types_.find(topic);
  if (found != types_.end() && fits(found->second)) return;
  std::string fitting;
  std::string others;
  std::string wanted;
  for (const std::string& type : datatypes) wanted += (wanted.empty() ? "" : " or ") + type;
  for (const auto& [name, type] : types_) {
    if (fits(type)) {
      fitting += (fitting.empty() ? "" : ", ") + name;
    } else {
      others += (others.empty() ? "" : ", ") + name + " (" + type + ")";
    }
  }
  const std::string wrong = topic.empty()           ? "no topic with clouds"
                            : found == types_.end() ? "no topic " + topic
                                                    : "topic " + topic + " is a " + found->second;
  throw std::runtime_error(names_ + ": " + wrong + "; topics of type " + wanted + ": " + (fitting.empty() ? "none" : fitting) +
                           "; others: " + (others.empty() ? "none" : others));
}

std::vector<std::string> BagFiles::topics(const std::string& datatype) const {
  std::vector<std::string> names;
  for (const auto& [name, type] : types_) {
    if (type == datatype) names.push_back(name);
  }
  return names;
}

std::size_t BagFiles::count(const std::string& topic) const {
  return guarded(names_, [&] { return static_cast<std::size_t>(view({topic})->size()); });
}

std::unique_ptr<rosbag::View> BagFiles::view(const std::vector<std::string>& topics, ros::Time from, ros::Time to) const {
  return guarded(names_, [&] {
    auto view = std::make_unique<rosbag::View>();
    for (const auto& bag : bags_) view->addQuery(*bag, rosbag::TopicQuery(topics), from, to);
    return view;
  });
}

ros::Time BagFiles::begin() const {
  return guarded(names_, [&] {
    rosbag::View view;
    for (const auto& bag : bags_) view.addQuery(*bag);
    return view.getBeginTime();
  });
}

void BagFiles::read_static_transforms(StaticTransforms& transforms) const {
  const auto messages = view({"/tf_static", "tf_static"});
  guarded(names_, [&] {
    for (const rosbag::MessageInstance& instance : *messages) {
      if (const auto message = instance.instantiate<tf2_msgs::TFMessage>()) transforms.add(*message);
    }
  });
}

void BagFiles::read_constant_transforms(StaticTransforms& transforms) const {
  const auto messages = view({"/tf", "tf"});
  struct Edge {
    geometry_msgs::TransformStamped transform;
    Pose pose;
    int count = 0;
    bool constant = true;
  };
  std::map<std::pair<std::string, std::string>, Edge> edges;
  guarded(names_, [&] {
    for (const rosbag::MessageInstance& instance : *messages) {
      const auto message = instance.instantiate<tf2_msgs::TFMessage>();
      if (!message) continue;
      for (const geometry_msgs::TransformStamped& transform : message->transforms) {
        const auto pose = to_pose(transform.transform);
        if (!pose) continue;
        Edge& edge = edges[{transform.header.frame_id, transform.child_frame_id}];
        if (edge.count++ == 0) edge.transform = transform, edge.pose = pose.value;
        edge.constant = edge.constant && (pose.value.translation - edge.pose.translation).norm() < 1e-6 &&
                        pose.value.rotation.angularDistance(edge.pose.rotation) < 1e-6;
      }
    }
  });
  tf2_msgs::TFMessage constant;
  for (const auto& [names, edge] : edges) {
    if (edge.constant && edge.count > 1) constant.transforms.push_back(edge.transform);
  }
  transforms.add(constant);
}

}  // namespace sgraph
