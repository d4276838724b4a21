#include "sgraph_slam/ros/health.hpp"

#include <ros/console.h>
#include <ros/time.h>

#include <cmath>
#include <cstdio>

namespace sgraph {

namespace {

constexpr auto silence = std::chrono::seconds(5);  // the slowest LiDARs turn once a second
constexpr auto shown_for = std::chrono::seconds(5);
constexpr auto logged_again_after = std::chrono::seconds(10);
constexpr std::size_t most_reports = 100;  // texts may hold names from outside

}  // namespace

Health::Health(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const std::string& name)
    : name_(name), updater_(node, private_node, name) {
  updater_.setHardwareID("none");
  updater_.add("status", this, &Health::describe);
  timer_ = node.createWallTimer(ros::WallDuration(1), [this](const ros::WallTimerEvent&) { updater_.force_update(); });
}

void Health::expect_input() {
  const std::lock_guard<std::mutex> lock(mutex_);
  expects_input_ = true;
}

void Health::worked(double milliseconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  last_input_ = Clock::now();
  ++worked_;
  milliseconds_ += milliseconds;
  most_milliseconds_ = std::max(most_milliseconds_, milliseconds);
}

void Health::count(const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  last_input_ = Clock::now();
  ++counts_[what];
}

void Health::show(const std::string& name, const std::string& value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  values_[name] = value;
}

void Health::show(const std::string& name, double value) {
  char text[40];
  std::snprintf(text, sizeof text, value == std::round(value) ? "%.0f" : "%.3f", value);  // counts as counts
  show(name, text);
}

void Health::warn(const std::string& text) { report(diagnostic_msgs::DiagnosticStatus::WARN, text); }

void Health::error(const std::string& text) { report(diagnostic_msgs::DiagnosticStatus::ERROR, text); }

void Health::report(int level, const std::string& text) {
  const auto now = Clock::now();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto [place, is_new] = reports_.try_emplace(text);
    if (is_new && reports_.size() > most_reports) {
      auto oldest = reports_.begin();
      for (auto it = reports_.begin(); it != reports_.end(); ++it)
        if (it != place && it->second.seen < oldest->second.seen) oldest = it;
      reports_.erase(oldest == place ? std::next(place) : oldest);
    }
    Report& report = place->second;
    report.level = level;
    ++report.count;
    report.seen = now;
    if (!is_new && now - report.logged < logged_again_after) return;
    report.logged = now;
  }
  if (level == diagnostic_msgs::DiagnosticStatus::ERROR) {
    ROS_ERROR_STREAM(name_ << ": " << text);
  } else {
    ROS_WARN_STREAM(name_ << ": " << text);
  }
}

void Health::summarise(diagnostic_updater::DiagnosticStatusWrapper& status, Clock::time_point now) const {
  using diagnostic_msgs::DiagnosticStatus;
  const auto silent = std::chrono::duration_cast<std::chrono::seconds>(now - last_input_);
  const bool started = worked_ > 0;
  if (expects_input_ && silent >= silence) {
    status.summary(DiagnosticStatus::WARN, (started ? "no input for " : "waiting for input for ") + std::to_string(silent.count()) + " s");
  } else {
    status.summary(DiagnosticStatus::OK, started ? "running" : "waiting for input");
  }
  // Scans carry their own time and are mapped; transforms are sent by the clock.
  if (ros::Time::isSimTime() && ros::Time::now().isZero())
    status.mergeSummary(DiagnosticStatus::WARN, "use_sim_time is set and no clock has come: no transform from map to odom");
}

void Health::describe(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto now = Clock::now();
  summarise(status, now);
  for (const auto& [text, report] : reports_)
    if (now - report.seen < shown_for) status.mergeSummary(static_cast<unsigned char>(report.level), text);

  const double seconds = std::chrono::duration<double>(now - last_message_).count();
  const auto recently = static_cast<double>(worked_ - worked_before_);
  status.add("processed", worked_);
  status.addf("rate [Hz]", "%.2f", seconds > 0 ? recently / seconds : 0);
  status.addf("mean time [ms]", "%.2f", recently > 0 ? milliseconds_ / recently : 0);
  status.addf("longest time [ms]", "%.2f", most_milliseconds_);
  for (const auto& [name, value] : values_) status.add(name, value);
  for (const auto& [what, number] : counts_) status.add(what, number);
  for (const auto& [text, report] : reports_) status.add(text, report.count);
  worked_before_ = worked_;
  milliseconds_ = 0;
  most_milliseconds_ = 0;
  last_message_ = now;
}

}  // namespace sgraph
