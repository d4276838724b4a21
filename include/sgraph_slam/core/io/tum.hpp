#pragma once

#include <iosfwd>
#include <string>

#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// Reads poses in the TUM format: `stamp x y z qx qy qz qw` a line, seconds and metres, `#` starts a comment. Stamps are taken digit by digit, exact
/// to the nanosecond. Throws std::runtime_error that names the file and line: unreadable, not eight numbers, not finite, a quaternion far from length
/// 1, stamps that don't increase. A file without poses gives an empty trajectory.
Trajectory read_tum(const std::string& path);
Trajectory read_tum(std::istream& in, const std::string& name);

/// Writes the same format with nine digits. Throws std::runtime_error when the file can't be written.
void write_tum(const Trajectory& trajectory, const std::string& path);
void write_tum(const Trajectory& trajectory, std::ostream& out);

}  // namespace sgraph
