#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "static_transforms.hpp"

namespace sgraph {

/// One or several bags opened for reading.
class BagFiles {
 public:
  /// Throws std::runtime_error: a file that is missing, no bag, truncated, or all of them empty.
  explicit BagFiles(const std::vector<std::string>& paths);

  /// Throws std::runtime_error, with the topics there are, unless the topic is there and of one of these types. An empty name is no topic.
  void require(const std::string& topic, const std::vector<std::string>& datatypes) const;
  /// The topics of a type, and how many messages one has.
  [[nodiscard]] std::vector<std::string> topics(const std::string& datatype) const;
  [[nodiscard]] std::size_t count(const std::string& topic) const;

  /// The messages of some topics within a time span, merged by their times.
  [[nodiscard]] std::unique_ptr<rosbag::View> view(const std::vector<std::string>& topics, ros::Time from = ros::TIME_MIN,
                                                   ros::Time to = ros::TIME_MAX) const;

  [[nodiscard]] ros::Time begin() const;
  /// All of /tf_static, wherever in the recording it is.
  void read_static_transforms(StaticTransforms& transforms) const;
  /// The transforms of /tf that never change: robots that publish them all there are older than /tf_static.
  void read_constant_transforms(StaticTransforms& transforms) const;

  /// Runs `read` and turns what rosbag throws at damaged files into one sentence.
  template <class Read>
  static auto guarded(const std::string& what, Read&& read) {
    try {
      return read();
    } catch (const rosbag::BagException& error) {
      throw std::runtime_error(damaged(what, error.what()));
    } catch (const ros::serialization::StreamOverrunException& error) {
      throw std::runtime_error(damaged(what, error.what()));
    } catch (const std::bad_alloc&) {
      throw std::runtime_error(damaged(what, "impossible sizes"));
    }
  }

  /// The paths, for messages.
  [[nodiscard]] const std::string& names() const { return names_; }

 private:
  static std::string damaged(const std::string& what, const std::string& why);

  std::vector<std::unique_ptr<rosbag::Bag>> bags_;
  std::map<std::string, std::string> types_;  // by topic
  std::string names_;
};

}  // namespace sgraph
