#pragma once

#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

/// Parameter values by full name ("prefilter.leaf"), each a scalar as text.
using ParamValues = std::map<std::string, std::string>;

/// All that is wrong with a set of parameters, one line an error.
class ParamError : public std::runtime_error {
 public:
  explicit ParamError(const std::vector<std::string>& errors);
  [[nodiscard]] const std::vector<std::string>& errors() const { return errors_; }

 private:
  std::vector<std::string> errors_;
};

using Describe = std::function<void(ParamVisitor&)>;

/// Values of a YAML file with nested maps. Throws ParamError: unreadable file, bad YAML (with the line), a value that is not a scalar.
ParamValues read_yaml_values(const std::string& path);

/// "name=value" as given on a command line. Throws ParamError.
void set_value(ParamValues& values, const std::string& assignment);

/// Writes the values into the described struct. Throws ParamError that lists *every* unknown name (with the nearest known one), value of the wrong
/// kind, and value out of range; the struct is then unspecified.
void apply_values(const ParamValues& values, const Describe& describe);

/// The struct as YAML with nested maps, and as a Markdown table (name, default, unit, range, meaning).
std::string to_yaml(const Describe& describe);
std::string to_markdown(const Describe& describe);

}  // namespace sgraph
