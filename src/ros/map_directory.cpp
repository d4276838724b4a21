#include "sgraph_slam/ros/map_directory.hpp"

#include <algorithm>

namespace sgraph {

std::optional<std::filesystem::path> inside(const std::filesystem::path& directory, const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  // The directory may not exist yet; weakly_canonical resolves links in the part that does.
  const fs::path root = fs::weakly_canonical(fs::absolute(directory), error);
  if (error) return {};
  const fs::path target = fs::weakly_canonical(root / path, error);
  if (error) return {};
  // Without the empty last part that a trailing slash leaves.
  const fs::path clean_root = root.has_filename() ? root : root.parent_path();
  const fs::path clean = target.has_filename() ? target : target.parent_path();
  const auto [end, at] = std::mismatch(clean_root.begin(), clean_root.end(), clean.begin(), clean.end());
  return end == clean_root.end() ? std::optional(clean) : std::nullopt;
}

std::string new_map_file(const RosSettings& settings) { return (std::filesystem::absolute(settings.map_directory) / "map.sgmap").string(); }

std::filesystem::path map_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error) ? path / "map.sgmap" : path;
}

SessionStart start_of(const RosSettings& settings) {
  if (settings.map.empty()) return {};
  // Whoever launches may name any file; services may not.
  return make_start(map_file(std::filesystem::absolute(settings.map_directory) / settings.map).string(), settings.map_mode, settings.start);
}

}  // namespace sgraph
