#pragma once

#include <string>
#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// What is known of one beam's errors.
struct BeamCalibration {
  double range_offset = 0;      ///< by how much the beam's ranges are too long [m]; the mean over the beams is zero
  double range_sigma = 0;       ///< its standard deviation [m]
  bool range_applied = false;   ///< known better than it needs to be
  double elevation_offset = 0;  ///< true elevation less the nominal one [rad]
  double elevation_sigma = 0;
  bool elevation_applied = false;
};

/// Errors of a spinning LiDAR's beams, by ring number as the clouds have it.
struct RingCalibration {
  std::vector<BeamCalibration> beams;
  std::vector<double> vertical_offsets;  ///< height of each beam's origin that the cloud may lack [m]; empty: none is known
  double vertical_share = 0;             ///< estimated share of these offsets that the cloud lacks: 0 or 1 in truth
  double vertical_sigma = 0;
  bool vertical_settled = false;  ///< whether the data holds it; until it does, elevations may stand for these offsets
  bool vertical_applied = false;
  int scans = 0;  ///< that it was estimated from

  /// Whether anything is corrected.
  [[nodiscard]] bool corrects() const;
  /// The cloud with what is applied taken out; the same cloud where nothing is. Only of a cloud whose points are as the sensor saw them.
  [[nodiscard]] CloudPtr corrected(const CloudPtr& cloud) const;
  /// The same for points, in place.
  void correct(std::vector<Point>& points) const;
  /// One line for the log and diagnostics.
  [[nodiscard]] std::string text() const;
};

/// As a YAML file: offsets in mm and degrees, standard deviations, what is applied.
std::string to_yaml(const RingCalibration& calibration);
/// Reads such a file. Throws std::runtime_error with file and reason.
RingCalibration read_calibration(const std::string& path);

}  // namespace sgraph
