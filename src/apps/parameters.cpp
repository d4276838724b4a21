// Prints the package's parameters with their defaults: as YAML, or as the page docs/parameters.md.
#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/params.hpp"

int main(int argc, char** argv) {
  CLI::App app("Prints every parameter with its default");
  std::string format = "yaml";
  app.add_option("format", format, "yaml (a file to start from) or markdown (docs/parameters.md)")->check(CLI::IsMember({"yaml", "markdown"}));
  CLI11_PARSE(app, argc, argv);

  sgraph::Params params;
  std::cout << (format == "yaml" ? sgraph::to_yaml([&params](sgraph::ParamVisitor& v) { params.describe(v); }) : sgraph::parameters_page());
  return 0;
}
