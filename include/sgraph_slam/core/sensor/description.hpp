#pragma once

#include <string>
#include <vector>

namespace sgraph {

/// What was recognised of a sensor from its first clouds. Words are those of report.json; "unknown" where the clouds don't tell.
struct SensorDescription {
  std::string model = "unknown";             ///< by the table of its angles, e.g. "VLP-16"
  int rings = 0;                             ///< beams; 0: unknown
  std::vector<double> elevations_deg;        ///< of each ring, the lowest first
  std::vector<double> vertical_offsets_m;    ///< height of each ring's origin on the axis, as the cloud has it
  std::string ring_source = "none";          ///< "field", "elevation" or "none"
  std::string vertical_offsets = "unknown";  ///< "applied", or "absent": all beams of the cloud start at one point
  std::string sweep = "unknown";             ///< "clockwise" or "counterclockwise", seen from above
  std::string time_source = "none";          ///< "field NAME", "azimuth" or "none"
  std::string time_unit;                     ///< of the field: "s", "ms", "us", "ns"
  std::string time_origin;                   ///< of the field: "stamp", "absolute" or "own clock"; "reversed" when it counts backwards
  std::string stamp = "unknown";             ///< "first", "last" or "inside": which firing bears the cloud's stamp
  double turn = 0;                           ///< time of one turn [s]; 0: unknown
  double coverage_deg = 0;                   ///< part of a turn that one message covers
  bool slices = false;                       ///< messages are parts of a turn and get joined
  bool intensity = false;                    ///< clouds tell intensities

  /// One line for the log.
  [[nodiscard]] std::string text() const;
};

}  // namespace sgraph
