#pragma once

#include <cstdint>
#include <string>

#include "sgraph_slam/core/sim/simulator.hpp"

namespace CLI {
class App;
}

namespace sgraph {

/// What the programs that simulate a world let the user choose about it.
struct SimulationOptions {
  std::string world;  ///< path of the world file
  std::string stamp = "last";
  std::string sensor = "ideal";
  std::string building = "auto";
  std::uint64_t unit = 1;
  std::uint64_t session = 0;
  sim::SimulationSettings settings;
};

/// Adds the options to a command line, the world's file first.
void declare(CLI::App& app, SimulationOptions& options);

/// Reads the world and gives it the errors and the session asked for; completes `options.settings`. Throws as `sim::read_world` does.
[[nodiscard]] sim::World read_world(SimulationOptions& options);

}  // namespace sgraph
