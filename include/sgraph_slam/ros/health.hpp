#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

namespace sgraph {

/// How a nodelet is doing, reported on /diagnostics once a second of real time, and in the log when something is wrong. All functions may be called
/// from any thread. The level is that of the worst report of the last seconds, so that what happened once is seen and what is over fades:
/// - OK: it works, or waits for something that need not come (a keyframe, while the robot stands);
/// - WARN: it works, but the result is worse than it could be, or its input has stopped: look at it when you can;
/// - ERROR: something is lost or can't be done until somebody acts.
/// docs/reliability.md says what to do about each report.
class Health {
 public:
  /// `name`: the nodelet's full name.
  Health(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const std::string& name);

  /// The nodelet's input is a sensor's: nothing for some seconds is a warning.
  void expect_input();

  /// One more of what the nodelet works on has been done, in so many milliseconds.
  void worked(double milliseconds);

  /// One more of something that isn't normal work, a drop for instance: shown with its number.
  void count(const std::string& what);

  /// A value to show.
  void show(const std::string& name, const std::string& value);
  void show(const std::string& name, double value);

  /// Something is wrong. Counted, shown, and logged when it is new or has not been said for a while.
  void warn(const std::string& text);
  void error(const std::string& text);

 private:
  using Clock = std::chrono::steady_clock;

  struct Report {
    int level = 0;
    std::int64_t count = 0;
    Clock::time_point seen;
    Clock::time_point logged;
  };

  void report(int level, const std::string& text);
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status);
  /// "running", or what the nodelet waits for.
  void summarise(diagnostic_updater::DiagnosticStatusWrapper& status, Clock::time_point now) const;

  const std::string name_;
  std::mutex mutex_;  // guards the members down to the updater
  std::map<std::string, Report> reports_;
  std::map<std::string, std::int64_t> counts_;
  std::map<std::string, std::string> values_;
  std::int64_t worked_ = 0;
  std::int64_t worked_before_ = 0;  // at the last message
  double milliseconds_ = 0;         // since the last message
  double most_milliseconds_ = 0;
  bool expects_input_ = false;
  Clock::time_point last_input_ = Clock::now();  // last sign of any, good or bad
  Clock::time_point last_message_ = Clock::now();

  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;  // last: it calls the updater
};

}  // namespace sgraph
