#include "simulation_options.hpp"

#include <CLI/CLI.hpp>

namespace sgraph {

void declare(CLI::App& app, SimulationOptions& options) {
  sim::LidarSettings& lidar = options.settings.lidar;
  app.add_option("world", options.world, "World file (docs/worlds.md)")->required();
  CLI::Option* noise = app.add_option("--noise", lidar.range_noise, "Standard deviation of the ideal sensor's ranges [m]")
                           ->capture_default_str()
                           ->check(CLI::Range(0.0, 1.0));
  app.add_option("--sensor", options.sensor, "ideal: white noise only; real: the errors of a real VLP-16 (docs/simulator.md)")
      ->capture_default_str()
      ->check(CLI::IsMember({"ideal", "real"}));
  app.add_option("--unit", options.unit, "Number of the real sensor: each has its own errors")->capture_default_str()->excludes(noise);
  app.add_option("--session", options.session, "Another day in the same building: other route, furniture moved, doors shut; 0: as in the file")
      ->capture_default_str();
  app.add_option("--building", options.building, "ideal: as planned; real: with the errors of real buildings; auto: like the sensor")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "ideal", "real"}));
  app.add_option("--rate", lidar.rate, "Revolutions a second")->capture_default_str()->check(CLI::Range(5.0, 20.0));
  app.add_option("--seed", lidar.seed, "Seed of all random numbers")->capture_default_str();
  app.add_option("--stamp", options.stamp, "Which firing stamps a cloud")->capture_default_str()->check(CLI::IsMember({"first", "last"}));
  app.add_option("--duration", options.settings.duration, "End after this long [s]; 0: the whole route")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
}

sim::World read_world(SimulationOptions& options) {
  sim::LidarSettings& lidar = options.settings.lidar;
  lidar.stamp = options.stamp == "first" ? sim::StampConvention::first : sim::StampConvention::last;
  const bool real = options.sensor == "real";
  if (real) lidar.unit = sim::real_unit(options.unit);
  sim::World world = sim::read_world(options.world);
  if (options.building == "real" || (options.building == "auto" && real)) world = sim::with_building_errors(world);
  if (options.session > 0) world = sim::with_session(world, options.session);
  return world;
}

}  // namespace sgraph
