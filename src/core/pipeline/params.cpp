#include "sgraph_slam/core/pipeline/params.hpp"

#include "sgraph_slam/core/params/params_io.hpp"

namespace sgraph {

std::string parameters_page() {
  Params defaults;
  return "# Parameters\n\n"
         "Every parameter of the package, as the code declares them (`rosrun sgraph_slam parameters markdown` prints this page,\n"
         "`rosrun sgraph_slam parameters yaml` a file with the defaults to start from).\n\n"
         "Give a YAML file with `run_bag --config FILE` or the launch files' `config` argument, single values with `run_bag --set NAME=VALUE`.\n"
         "An unknown name, a value of the wrong kind and a value outside its range stop the start; all errors are listed at once.\n\n" +
         to_markdown([&defaults](ParamVisitor& v) { defaults.describe(v); });
}

}  // namespace sgraph
