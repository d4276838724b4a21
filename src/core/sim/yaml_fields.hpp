#pragma once

#include <set>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>
#include <Eigen/Core>

#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// Throws WorldError "file:line: message".
[[noreturn]] void fail_at(const std::string& file, int line, const std::string& message);

/// Line of a node counted from 1; 0 when it has none.
int line_of(const YAML::Node& node);

/// Limits of a number, both allowed.
struct Limits {
  double low = -1e4;
  double high = 1e4;
};

/// One map of a world's file: reads keys with their kind and limits checked, and refuses at the end what nobody asked for.
class Fields {
 public:
  Fields(YAML::Node node, std::string file, std::string what);

  [[nodiscard]] bool has(const char* key) const;
  /// The value, marked as read; a null node when it is missing.
  YAML::Node take(const char* key);
  /// The value; fails when it is missing.
  YAML::Node need(const char* key);

  double number(const char* key, double otherwise, Limits limits);
  int integer(const char* key, int otherwise, int low, int high);
  bool flag(const char* key, bool otherwise);
  std::string text(const char* key, const std::string& otherwise);
  Material material(const char* key, Material otherwise);
  Eigen::Vector2d point(const char* key);

  /// Fails when the map has a key that was never taken. Call it last.
  void finish() const;

  [[noreturn]] void fail(const YAML::Node& at, const std::string& message) const;
  [[nodiscard]] int line() const { return line_of(node_); }
  [[nodiscard]] const std::string& file() const { return file_; }

  /// A list of `count` numbers; any number of them when count is 0.
  [[nodiscard]] std::vector<double> numbers(const YAML::Node& node, std::size_t count) const;
  [[nodiscard]] Eigen::Vector2d point_of(const YAML::Node& node) const;
  [[nodiscard]] std::vector<Eigen::Vector2d> points_of(const YAML::Node& node, std::size_t at_least) const;
  /// The elements of a list; fails when it is something else. Empty for a missing node.
  [[nodiscard]] std::vector<YAML::Node> list_of(const YAML::Node& node) const;

 private:
  double to_number(const YAML::Node& node, const std::string& name) const;

  YAML::Node node_;
  std::string file_;
  std::string what_;
  std::set<std::string> taken_;
};

}  // namespace sgraph::sim
