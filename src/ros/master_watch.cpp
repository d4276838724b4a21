#include "sgraph_slam/ros/master_watch.hpp"

#include <ros/connection_manager.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/publication.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <set>

namespace sgraph {

namespace {

using XmlRpc::XmlRpcValue;

constexpr std::chrono::seconds period{1};

/// What a ROS master or node answers: a number that says whether it could (1) or not, a text, and the value.
struct Answer {
  bool done = false;
  XmlRpcValue value;
};

/// Nothing when it can't be reached. Clients of our own: roscpp deletes its when the node ends, whether one is in use or not.
std::optional<Answer> call(const std::string& host, std::uint32_t port, const char* method, const std::vector<std::string>& words,
                           const XmlRpcValue* list = nullptr) {
  XmlRpcValue arguments;
  arguments[0] = ros::this_node::getName();
  int n = 1;
  for (const std::string& word : words) arguments[n++] = word;
  if (list) arguments[n] = *list;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpcValue response;
  try {
    const bool answered = client.execute(method, arguments, response);
    client.close();
    if (!answered || client.isFault() || response.getType() != XmlRpcValue::TypeArray || response.size() != 3) return {};
    return Answer{static_cast<int>(response[0]) == 1, response[2]};
  } catch (const XmlRpc::XmlRpcException&) {
    return {};
  }
}

std::optional<Answer> master(const char* method, const std::vector<std::string>& words) {
  return call(ros::master::getHost(), ros::master::getPort(), method, words);
}

std::optional<Answer> ourselves(const char* method, const std::vector<std::string>& words, const XmlRpcValue* list = nullptr) {
  return call(ros::network::getHost(), ros::XMLRPCManager::instance()->getServerPort(), method, words, list);
}

/// The names of this node's services, as the master knows them.
std::vector<std::string> registered_services() {
  std::vector<std::string> names;
  auto state = master("getSystemState", {});
  if (!state || !state->done) return names;
  XmlRpcValue& services = state->value[2];  // after publishers and subscribers: [[service, [node, ...]], ...]
  for (int i = 0; i < services.size(); ++i) {
    XmlRpcValue& nodes = services[i][1];
    for (int k = 0; k < nodes.size(); ++k) {
      if (static_cast<std::string>(nodes[k]) == ros::this_node::getName()) names.push_back(static_cast<std::string>(services[i][0]));
    }
  }
  return names;
}

/// Addresses of the nodes from which a topic comes now.
std::set<std::string> connected_publishers(const std::string& topic) {
  std::set<std::string> addresses;
  auto bus = ourselves("getBusInfo", {});
  for (int i = 0; bus && bus->done && i < bus->value.size(); ++i) {
    XmlRpcValue& connection = bus->value[i];  // [number, address, direction, transport, topic, ...]
    if (static_cast<std::string>(connection[2]) == "i" && static_cast<std::string>(connection[4]) == topic) {
      addresses.insert(static_cast<std::string>(connection[1]));
    }
  }
  return addresses;
}

/// False when the master didn't take everything: it may be going again.
bool register_again(const std::vector<std::string>& services) {
  const std::string own = ros::XMLRPCManager::instance()->getServerURI();
  const auto taken = [](const std::optional<Answer>& answer) { return answer && answer->done; };

  // Publishers first, so that the master knows them when it is asked who publishes what this node listens to.
  ros::V_string topics;
  ros::TopicManager::instance()->getAdvertisedTopics(topics);
  for (const std::string& topic : topics) {
    const ros::PublicationPtr publication = ros::TopicManager::instance()->lookupPublication(topic);
    if (publication && !taken(master("registerPublisher", {topic, publication->getDataType(), own}))) return false;
  }
  const std::string service_address = "rosrpc://" + ros::network::getHost() + ":" + std::to_string(ros::ConnectionManager::instance()->getTCPPort());
  for (const std::string& service : services) {
    if (!taken(master("registerService", {service, service_address, own}))) return false;
  }
  topics.clear();
  ros::TopicManager::instance()->getSubscribedTopics(topics);
  for (const std::string& topic : topics) {
    auto answer = master("registerSubscriber", {topic, "*", own});
    if (!taken(answer)) return false;
    // roscpp lets go of a publisher that isn't in the list; the ones it is connected to need not have found the new master yet.
    std::set<std::string> publishers = connected_publishers(topic);
    for (int i = 0; i < answer->value.size(); ++i) publishers.insert(static_cast<std::string>(answer->value[i]));
    XmlRpcValue list;
    list.setSize(static_cast<int>(publishers.size()));
    int n = 0;
    for (const std::string& address : publishers) list[n++] = address;
    ourselves("publisherUpdate", {topic}, &list);
  }
  return true;
}

}  // namespace

MasterWatch::MasterWatch() : services_(registered_services()), thread_([this] { run(); }) {}

MasterWatch::~MasterWatch() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void MasterWatch::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!changed_.wait_for(lock, period, [this] { return stop_; })) {
    lock.unlock();
    const auto answer = master("lookupNode", {ros::this_node::getName()});
    // A node that is being ended has taken its name off the master's list by itself.
    if (answer && !answer->done && ros::ok() && !ros::isShuttingDown()) {
      if (register_again(services_)) {
        ROS_WARN("the master was started again and didn't know this node; its topics and services are registered again");
      } else {
        ROS_ERROR("the master was started again, and this node could not be registered with it; trying again");
      }
    }
    lock.lock();
  }
}

}  // namespace sgraph
