#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace sgraph {

/// The folder meant by a path that came with a service call: inside `directory`, or that itself for an empty path. Nothing when the path leads
/// elsewhere, by "..", as an absolute path, or through a symbolic link.
std::optional<std::filesystem::path> inside(const std::filesystem::path& directory, const std::string& path);

}  // namespace sgraph
