#include "readers.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "sgraph_slam/core/graph/g2o.hpp"
#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/io/pcd.hpp"
#include "sgraph_slam/core/io/tum.hpp"
#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/params.hpp"
#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::fuzz {

namespace {

/// Runs it; what it refuses with the documented kind of exception is fine.
template <class Refusal, class Function>
void allow(Function function) {
  try {
    function();
  } catch (const Refusal&) {
  }
}

void read_world_text(std::string_view bytes) {
  allow<sim::WorldError>([&] { sim::parse_world(std::string(bytes), "fuzz.yaml", "/nonexistent"); });
}

void read_configuration(std::string_view bytes) {
  const ScratchFile file(bytes);
  allow<ParamError>([&] {
    Params params;
    apply_values(read_yaml_values(file.path()), [&params](ParamVisitor& v) { params.describe(v); });
  });
}

void read_graph_json(std::string_view bytes) {
  allow<std::runtime_error>([&] {
    const GraphSnapshot snapshot = parse_graph_json(std::string(bytes));
    const std::string text = graph_json(snapshot);
    expect(graph_json(parse_graph_json(text)) == text, "graph.json that was read can be written and read again");
  });
}

void read_graph(std::string_view bytes) {
  allow<std::runtime_error>([&] {
    const std::string text = to_json(graph_from_json(std::string(bytes)));
    expect(to_json(graph_from_json(text)) == text, "a graph that was read can be written and read again");
  });
}

void read_tum_text(std::string_view bytes) {
  allow<std::runtime_error>([&] {
    std::istringstream in{std::string(bytes)};
    const Trajectory trajectory = read_tum(in, "fuzz.tum");
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
      expect(trajectory[i].pose.translation.allFinite() && trajectory[i].pose.rotation.coeffs().allFinite(), "poses are finite");
      expect(i == 0 || trajectory[i - 1].stamp < trajectory[i].stamp, "stamps increase");
    }
  });
}

void read_g2o_text(std::string_view bytes) {
  const ScratchFile file(bytes);
  allow<std::runtime_error>([&] {
    const Graph graph = read_g2o(file.path());
    expect(to_json(graph_from_json(to_json(graph))) == to_json(graph), "a pose graph that was read is a valid graph");
  });
}

void read_pcd(std::string_view bytes) {
  const ScratchFile file(bytes);
  allow<std::runtime_error>([&] {
    for (const Eigen::Vector3f& point : read_pcd_positions(file.path())) expect(point.allFinite(), "positions are finite");
  });
}

}  // namespace

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> all{
      {"configuration", read_configuration},
      {"g2o", read_g2o_text},
      {"graph", read_graph},
      {"graph_json", read_graph_json},
      {"pcd", read_pcd},
      {"point_cloud", read_point_cloud},
      {"store", read_store},
      {"stored_cloud", read_stored_cloud},
      {"tum", read_tum_text},
      {"velodyne_scan", read_velodyne_scan},
      {"world", read_world_text},
  };
  return all;
}

void expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

ScratchFile::ScratchFile(std::string_view bytes) : descriptor_(memfd_create("fuzz", 0)) {
  expect(descriptor_ >= 0, "a file in memory can be made");
  path_ = "/proc/self/fd/" + std::to_string(descriptor_);
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t n = write(descriptor_, bytes.data() + written, bytes.size() - written);
    expect(n > 0, "a file in memory can be written");
    written += static_cast<std::size_t>(n);
  }
}

ScratchFile::~ScratchFile() { close(descriptor_); }

}  // namespace sgraph::fuzz
