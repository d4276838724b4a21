#include "yaml_fields.hpp"

#include <cmath>
#include <sstream>

namespace sgraph::sim {

void fail_at(const std::string& file, int line, const std::string& message) {
  throw WorldError(file + (line > 0 ? ":" + std::to_string(line) : std::string()) + ": " + message);
}

int line_of(const YAML::Node& node) { return node.IsDefined() && !node.Mark().is_null() ? node.Mark().line + 1 : 0; }

Fields::Fields(YAML::Node node, std::string file, std::string what) : node_(std::move(node)), file_(std::move(file)), what_(std::move(what)) {
  if (!node_.IsMap()) fail(node_, what_ + " must be a map of keys and values");
}

bool Fields::has(const char* key) const { return static_cast<const YAML::Node&>(node_)[key].IsDefined(); }

YAML::Node Fields::take(const char* key) {
  taken_.insert(key);
  return has(key) ? static_cast<const YAML::Node&>(node_)[key] : YAML::Node(YAML::NodeType::Null);
}

YAML::Node Fields::need(const char* key) {
  if (!has(key)) fail(node_, what_ + " needs `" + key + "`");
  return take(key);
}

double Fields::to_number(const YAML::Node& node, const std::string& name) const {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) fail(node, name + " must be a number");
  return value;
}

double Fields::number(const char* key, double otherwise, Limits limits) {
  const YAML::Node node = take(key);
  if (node.IsNull()) return otherwise;
  const double value = to_number(node, std::string("`") + key + "`");
  if (value < limits.low || value > limits.high) {
    std::ostringstream text;
    text << "`" << key << "` is " << value << ", must be between " << limits.low << " and " << limits.high;
    fail(node, text.str());
  }
  return value;
}

int Fields::integer(const char* key, int otherwise, int low, int high) {
  const double value = number(key, otherwise, {static_cast<double>(low), static_cast<double>(high)});
  if (value != std::floor(value)) fail(take(key), std::string("`") + key + "` must be a whole number");
  return static_cast<int>(value);
}

bool Fields::flag(const char* key, bool otherwise) {
  const YAML::Node node = take(key);
  if (node.IsNull()) return otherwise;
  bool value = false;
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)) fail(node, std::string("`") + key + "` must be true or false");
  return value;
}

std::string Fields::text(const char* key, const std::string& otherwise) {
  const YAML::Node node = take(key);
  if (node.IsNull()) return otherwise;
  if (!node.IsScalar()) fail(node, std::string("`") + key + "` must be text");
  return node.Scalar();
}

Material Fields::material(const char* key, Material otherwise) {
  static const std::map<std::string, Material> known{{"plaster", Material::plaster}, {"concrete", Material::concrete}, {"wood", Material::wood},
                                                     {"fabric", Material::fabric},   {"metal", Material::metal},       {"glass", Material::glass},
                                                     {"ground", Material::ground}};
  const YAML::Node node = take(key);
  if (node.IsNull()) return otherwise;
  const auto found = node.IsScalar() ? known.find(node.Scalar()) : known.end();
  if (found == known.end()) fail(node, std::string("`") + key + "` must be plaster, concrete, wood, fabric, metal, glass or ground");
  return found->second;
}

Eigen::Vector2d Fields::point(const char* key) { return point_of(need(key)); }

void Fields::finish() const {
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (taken_.count(key) == 0) {
      std::string known;
      for (const std::string& name : taken_) known += (known.empty() ? "" : ", ") + name;
      fail(entry.first, what_ + " has no `" + key + "`; it knows " + known);
    }
  }
}

void Fields::fail(const YAML::Node& at, const std::string& message) const {
  const int line = line_of(at);
  fail_at(file_, line > 0 ? line : line_of(node_), message);
}

std::vector<double> Fields::numbers(const YAML::Node& node, std::size_t count) const {
  std::vector<double> values;
  if (!node.IsSequence() || (count != 0 && node.size() != count)) {
    fail(node, what_ + ": expected a list of " + (count != 0 ? std::to_string(count) + " " : std::string()) + "numbers");
  }
  for (const YAML::Node& element : node) values.push_back(to_number(element, what_ + ": each element"));
  return values;
}

Eigen::Vector2d Fields::point_of(const YAML::Node& node) const {
  const std::vector<double> values = numbers(node, 2);
  if (std::abs(values[0]) > 1e4 || std::abs(values[1]) > 1e4) fail(node, what_ + ": a point farther than 10 km from the origin");
  return {values[0], values[1]};
}

std::vector<Eigen::Vector2d> Fields::points_of(const YAML::Node& node, std::size_t at_least) const {
  std::vector<Eigen::Vector2d> points;
  for (const YAML::Node& element : list_of(node)) points.push_back(point_of(element));
  if (points.size() < at_least) fail(node, what_ + ": needs at least " + std::to_string(at_least) + " points");
  return points;
}

std::vector<YAML::Node> Fields::list_of(const YAML::Node& node) const {
  if (node.IsNull()) return {};
  if (!node.IsSequence()) fail(node, what_ + ": expected a list");
  std::vector<YAML::Node> elements;
  for (const YAML::Node& element : node) elements.push_back(element);
  return elements;
}

}  // namespace sgraph::sim
