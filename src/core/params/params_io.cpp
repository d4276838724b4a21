#include "sgraph_slam/core/params/params_io.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>

#include "named_visitor.hpp"

namespace sgraph {
namespace {

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  return text;
}

// Puts the scalars of nested maps into `values` under their full names.
void flatten(const YAML::Node& node, const std::string& name, ParamValues& values, std::vector<std::string>& errors) {
  const std::string line = "line " + std::to_string(node.Mark().line + 1) + ": ";
  if (node.IsMap()) {
    for (const auto& entry : node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      flatten(entry.second, name.empty() ? key : name + '.' + key, values, errors);
    }
  } else if (name.empty()) {
    errors.push_back(line + "expected names with values");
  } else if (!node.IsScalar()) {
    errors.push_back(line + name + (node.IsSequence() ? " is a list; expected one value" : " has no value"));
  } else if (!values.emplace(name, node.Scalar()).second) {
    errors.push_back(line + name + " is given twice");
  }
}

// Letters to insert, drop, replace or swap with their neighbour to make b of a.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        cost[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
    }
  }
  return cost.back().back();
}

std::string last_part(const std::string& name) { return name.substr(name.rfind('.') + 1); }

// The known name that was probably meant: same last word in another group, else the fewest letters to change. Nothing when all are far off.
std::optional<std::string> nearest(const std::string& name, const std::vector<std::string>& known) {
  std::optional<std::string> best;
  std::size_t least = name.size() / 2 + 1;
  for (const std::string& candidate : known) {
    const bool same_word = last_part(candidate) == last_part(name);
    const std::size_t distance = same_word ? 0 : std::min(edit_distance(name, candidate), 1 + edit_distance(name, last_part(candidate)));
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

template <class Number>
std::optional<Number> parse_number(const std::string& text) {
  const char* begin = text.data() + (!text.empty() && text.front() == '+' ? 1 : 0);
  Number value{};
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<bool> parse_bool(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (text == "true" || text == "yes" || text == "on") return true;
  if (text == "false" || text == "no" || text == "off") return false;
  return std::nullopt;
}

// Fills the fields it is shown from the values and collects what is wrong.
class Reader : public NamedVisitor {
 public:
  explicit Reader(const ParamValues& values) : values_(values) {}

  void field(const char* name, double& value, const char* unit, Range range, const char*) override {
    read_number(name, value, unit, range, "a number");
  }
  void field(const char* name, int& value, const char* unit, Range range, const char*) override {
    read_number(name, value, unit, range, "a whole number");
  }
  void field(const char* name, bool& value, const char*) override {
    const std::string* text = find(name);
    if (text == nullptr) return;
    if (const auto parsed = parse_bool(*text)) {
      value = *parsed;
    } else {
      errors_.push_back(full(name) + ": \"" + *text + "\" is neither true nor false");
    }
  }
  void field(const char* name, std::string& value, const char*) override {
    if (const std::string* text = find(name)) value = *text;
  }
  void choice(const char* name, std::string& value, const std::vector<std::string>& options, const char*) override {
    const std::string* text = find(name);
    if (text == nullptr) return;
    if (std::find(options.begin(), options.end(), *text) != options.end()) {
      value = *text;
      return;
    }
    std::string list;
    for (const std::string& option : options) list += (list.empty() ? "" : ", ") + option;
    errors_.push_back(full(name) + ": \"" + *text + "\" is none of " + list);
  }

  /// All errors, those of unknown names last.
  [[nodiscard]] std::vector<std::string> errors() const {
    std::vector<std::string> all = errors_;
    for (const auto& [name, text] : values_) {
      if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
      const auto meant = nearest(name, known_);
      all.push_back("unknown parameter " + name + (meant ? "; did you mean " + *meant + "?" : ""));
    }
    return all;
  }

 private:
  const std::string* find(const char* name) {
    known_.push_back(full(name));
    const auto found = values_.find(known_.back());
    return found == values_.end() ? nullptr : &found->second;
  }

  template <class Number>
  void read_number(const char* name, Number& value, const char* unit, Range range, const char* kind) {
    const std::string* text = find(name);
    if (text == nullptr) return;
    const auto parsed = parse_number<Number>(*text);
    if (!parsed) {
      errors_.push_back(full(name) + ": \"" + *text + "\" is not " + kind);
      return;
    }
    // Also refuses NaN.
    if (const double number = static_cast<double>(*parsed); !(number >= range.low && number <= range.high)) {
      errors_.push_back(full(name) + ": " + *text + " is outside " + number_text(range.low) + ".." + number_text(range.high) +
                        (*unit != '\0' ? std::string(" ") + unit : ""));
      return;
    }
    value = *parsed;
  }

  const ParamValues& values_;
  std::vector<std::string> known_;
  std::vector<std::string> errors_;
};

}  // namespace

std::string number_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

ParamError::ParamError(const std::vector<std::string>& errors) : std::runtime_error(joined(errors)), errors_(errors) {}

ParamValues read_yaml_values(const std::string& path) {
  ParamValues values;
  std::vector<std::string> errors;
  try {
    const YAML::Node root = YAML::LoadFile(path);
    if (!root.IsNull()) flatten(root, "", values, errors);
  } catch (const YAML::BadFile&) {
    throw ParamError({path + ": can't be read"});
  } catch (const YAML::Exception& error) {
    throw ParamError({path + ": line " + std::to_string(error.mark.line + 1) + ": " + error.msg});
  }
  for (std::string& error : errors) error = path + ": " + error;
  if (!errors.empty()) throw ParamError(errors);
  return values;
}

void set_value(ParamValues& values, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) throw ParamError({"\"" + assignment + "\" is not NAME=VALUE"});
  values[assignment.substr(0, equals)] = assignment.substr(equals + 1);
}

void apply_values(const ParamValues& values, const Describe& describe) {
  Reader reader(values);
  describe(reader);
  const auto errors = reader.errors();
  if (!errors.empty()) throw ParamError(errors);
}

}  // namespace sgraph
