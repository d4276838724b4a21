#pragma once

#include <string>
#include <string_view>

namespace sgraph {

/// Writes a file as a whole: under another name first, so that a reader, or a failure half-way, never meets half a file. Throws std::runtime_error
/// with the path and the system's reason (no space left, read-only, ...).
void write_file(const std::string& path, std::string_view bytes);

/// Makes a folder and those above it. Throws std::runtime_error with the reason when it can't, or when nothing can be written into it.
void make_folder(const std::string& path);

/// Throws std::runtime_error when it can't be read.
std::string read_file(const std::string& path);

}  // namespace sgraph
