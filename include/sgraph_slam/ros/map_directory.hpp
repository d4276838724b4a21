#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sgraph_slam/core/localisation/mapping_session.hpp"
#include "sgraph_slam/ros/settings.hpp"

namespace sgraph {

/// The folder meant by a path that came with a service call: inside `directory`, or that itself for an empty path. Nothing when the path leads
/// elsewhere, by "..", as an absolute path, or through a symbolic link.
std::optional<std::filesystem::path> inside(const std::filesystem::path& directory, const std::string& path);

/// Where new maps are written: `map.sgmap` in the map directory.
std::string new_map_file(const RosSettings& settings);

/// The map file that a path inside the map directory names: itself, or `map.sgmap` in the folder that it is.
std::filesystem::path map_file(const std::filesystem::path& path);

/// The map to take up that the settings name, none when they name none. Throws std::runtime_error with what is wrong.
SessionStart start_of(const RosSettings& settings);

}  // namespace sgraph
