#pragma once

#include <memory>
#include <optional>

#include <nodelet/nodelet.h>

#include "sgraph_slam/ros/health.hpp"
#include "sgraph_slam/ros/settings.hpp"

namespace sgraph {

/// What the four nodelets have in common: settings read once, diagnostics, and a refusal to start with bad settings.
class StageNodelet : public nodelet::Nodelet {
 protected:
  /// Builds the stage and subscribes last. Must not wait for anything.
  virtual void start() = 0;

  [[nodiscard]] const Settings& settings() const { return settings_; }
  Health& health() { return *health_; }

 private:
  void onInit() final;

  Settings settings_;
  std::unique_ptr<Health> health_;
};

/// How long a service may wait for work that is under way.
constexpr std::chrono::seconds service_limit{60};

}  // namespace sgraph
