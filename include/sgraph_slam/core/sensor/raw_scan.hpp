#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// A driver's cloud as its message holds it, before its conventions are known.
struct RawScan {
  Cloud cloud;                    ///< the points' times are 0, and so are rings and intensities that the message doesn't have
  std::vector<double> times;      ///< the field's value at each point, in its own unit and from its own origin; empty without such a field
  std::string time_field;         ///< its name
  bool integer_times = false;     ///< whether it holds whole numbers
  bool has_ring = false;          ///< whether the message numbers the beams
  bool has_intensity = false;     ///< whether it tells intensities
  std::optional<Stamp> received;  ///< when the message reached the computer that recorded it
};

}  // namespace sgraph
