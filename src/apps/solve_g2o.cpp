// Solves a pose graph in g2o format with the back end's solver, for comparison with other solvers on the standard benchmarks.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>

#include "sgraph_slam/core/graph/g2o.hpp"
#include "sgraph_slam/core/graph/solver.hpp"

namespace {

double since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Solves a 3D pose graph (g2o format: VERTEX_SE3:QUAT, EDGE_SE3:QUAT)");
  std::string in;
  std::string out;
  std::string start_from = "best";
  sgraph::SolverOptions options;
  options.max_iterations = 200;
  options.function_tolerance = 1e-9;
  app.add_option("input", in, "Pose graph to read")->required();
  app.add_option("output", out, "Solved pose graph to write");
  app.add_option("--start", start_from, "Where to start: the file's poses, the chordal relaxation, or whichever costs less")
      ->check(CLI::IsMember({"file", "chordal", "best"}))
      ->capture_default_str();
  std::string weights = "isotropic";
  app.add_option("--weights", weights,
                 "Information matrices: isotropic (one weight for rotation and one for translation an edge, the cost whose optima are published with "
                 "SE-Sync) "
                 "or full")
      ->check(CLI::IsMember({"isotropic", "full"}))
      ->capture_default_str();
  app.add_option("--iterations", options.max_iterations, "At most so many iterations")->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  try {
    sgraph::Graph graph = sgraph::read_g2o(in, weights == "full" ? sgraph::G2oWeights::full : sgraph::G2oWeights::isotropic);
    std::printf("%s: %zu poses, %zu edges\n", in.c_str(), graph.keyframes().size(), graph.factors().size());
    const double file_cost = sgraph::total_cost(graph);
    if (start_from != "file") {
      const auto start = std::chrono::steady_clock::now();
      sgraph::Graph relaxed = graph;
      sgraph::initialise_chordal(relaxed);
      const double chordal_cost = sgraph::total_cost(relaxed);
      std::printf("start: file cost %.8g, chordal cost %.8g (%.1f ms)\n", file_cost, chordal_cost, since(start));
      if (start_from == "chordal" || chordal_cost < file_cost) graph = relaxed;
    }
    const sgraph::SolveSummary summary = sgraph::solve(graph, options);
    std::printf("cost %.8g -> %.8g (half the sum of squares), %d iterations, %s, %.1f ms\n", summary.initial_cost, summary.final_cost,
                summary.iterations, summary.converged ? "converged" : "not converged", summary.milliseconds);
    if (!out.empty()) sgraph::write_g2o(out, graph);
    return summary.converged ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "solve_g2o: %s\n", error.what());
    return 1;
  }
}
