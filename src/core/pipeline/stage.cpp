#include "sgraph_slam/core/pipeline/stage.hpp"

#include "sgraph_slam/core/util/resources.hpp"

namespace sgraph {
namespace {

double cpu_milliseconds() { return 1e3 * thread_cpu_seconds(); }

}  // namespace

const char* to_string(Stage value) {
  switch (value) {
    case Stage::prefilter: return "prefilter";
    case Stage::odometry: return "odometry";
    case Stage::segmentation: return "segmentation";
    case Stage::mapping: break;
  }
  return "mapping";
}

std::optional<Stage> stage_from(const std::string& word) {
  for (const Stage stage : all_stages) {
    if (word == to_string(stage)) return stage;
  }
  return std::nullopt;
}

StageCost& StageCost::operator+=(const StageCost& other) {
  for (std::size_t i = 0; i < all_stages.size(); ++i) {
    wall[i] += other.wall[i];
    cpu[i] += other.cpu[i];
  }
  return *this;
}

StageClock::StageClock() : cpu_(cpu_milliseconds()) {}

void StageClock::book(Stage stage, StageCost& cost) {
  const double cpu = cpu_milliseconds();
  cost.wall[static_cast<std::size_t>(stage)] += wall_.lap();
  cost.cpu[static_cast<std::size_t>(stage)] += cpu - cpu_;
  cpu_ = cpu;
}

}  // namespace sgraph
