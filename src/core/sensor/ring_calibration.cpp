#include "sgraph_slam/core/sensor/ring_calibration.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace sgraph {
namespace {

constexpr double degree = M_PI / 180;
constexpr double most_range = 0.1;         // [m] a file with more is of another unit
constexpr double most_elevation = degree;  // [rad]

template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

}  // namespace

bool RingCalibration::corrects() const {
  return vertical_applied || std::any_of(beams.begin(), beams.end(), [](const BeamCalibration& b) { return b.range_applied || b.elevation_applied; });
}

CloudPtr RingCalibration::corrected(const CloudPtr& cloud) const {
  if (!corrects()) return cloud;
  auto result = std::make_shared<Cloud>(*cloud);
  correct(result->points);
  return result;
}

void RingCalibration::correct(std::vector<Point>& points) const {
  for (Point& p : points) {
    if (p.ring >= beams.size()) continue;
    const BeamCalibration& beam = beams[p.ring];
    const double x = p.x, y = p.y, z = p.z;
    const double rho = std::hypot(x, y);
    const double range = std::hypot(rho, z);
    if (!(rho > 0) || !std::isfinite(range)) continue;
    const double scale = beam.range_applied ? (range - beam.range_offset) / range : 1.0;
    const double turn = beam.elevation_applied ? beam.elevation_offset : 0.0;
    const double out = (rho * std::cos(turn) - z * std::sin(turn)) * scale / rho;
    const double up = (rho * std::sin(turn) + z * std::cos(turn)) * scale;
    const double raised = vertical_applied && p.ring < vertical_offsets.size() ? vertical_offsets[p.ring] : 0.0;
    p.x = static_cast<float>(x * out);
    p.y = static_cast<float>(y * out);
    p.z = static_cast<float>(up + raised);
  }
}

std::string RingCalibration::text() const {
  int ranges = 0, elevations = 0;
  double squares = 0, squares_e = 0;
  for (const BeamCalibration& beam : beams) {
    ranges += beam.range_applied;
    elevations += beam.elevation_applied;
    squares += beam.range_applied ? beam.range_offset * beam.range_offset : 0;
    squares_e += beam.elevation_applied ? beam.elevation_offset * beam.elevation_offset : 0;
  }
  const char* const vertical = vertical_applied ? "added" : vertical_settled || vertical_offsets.empty() ? "left as they are" : "not settled";
  return format("calibration: ranges of %d of %zu beams (rms %.1f mm), elevations of %d (rms %.3f deg), vertical offsets %s; %d scans", ranges,
                beams.size(), ranges > 0 ? 1e3 * std::sqrt(squares / ranges) : 0.0, elevations,
                elevations > 0 ? std::sqrt(squares_e / elevations) / degree : 0.0, vertical, scans);
}

std::string to_yaml(const RingCalibration& calibration) {
  std::string text = "# Errors of the LiDAR's beams, by ring number: ranges are too long by range_mm, elevations too low by elevation_deg.\n";
  text += format("format: 1\nscans: %d\nvertical: {share: %.3f, sigma: %.3f, settled: %s, applied: %s, offsets_mm: [", calibration.scans,
                 calibration.vertical_share, calibration.vertical_sigma, calibration.vertical_settled ? "true" : "false",
                 calibration.vertical_applied ? "true" : "false");
  for (std::size_t i = 0; i < calibration.vertical_offsets.size(); ++i)
    text += format(i == 0 ? "%.2f" : ", %.2f", 1e3 * calibration.vertical_offsets[i]);
  text += "]}\nbeams:\n";
  for (std::size_t ring = 0; ring < calibration.beams.size(); ++ring) {
    const BeamCalibration& b = calibration.beams[ring];
    text += format("  - {ring: %zu, range_mm: %.3f, range_sigma_mm: %.3f, range_applied: %s, ", ring, 1e3 * b.range_offset, 1e3 * b.range_sigma,
                   b.range_applied ? "true" : "false");
    text += format("elevation_deg: %.5f, elevation_sigma_deg: %.5f, elevation_applied: %s}\n", b.elevation_offset / degree,
                   b.elevation_sigma / degree, b.elevation_applied ? "true" : "false");
  }
  return text;
}

RingCalibration read_calibration(const std::string& path) {
  try {
    const YAML::Node root = YAML::LoadFile(path);
    if (root["format"].as<int>() != 1) throw std::runtime_error("is of another format");
    RingCalibration result;
    result.scans = root["scans"].as<int>(0);
    const YAML::Node vertical = root["vertical"];
    result.vertical_share = vertical["share"].as<double>();
    result.vertical_sigma = vertical["sigma"].as<double>();
    result.vertical_applied = vertical["applied"].as<bool>();
    result.vertical_settled = vertical["settled"].as<bool>(result.vertical_applied);
    for (const YAML::Node& offset : vertical["offsets_mm"]) result.vertical_offsets.push_back(1e-3 * offset.as<double>());
    for (const YAML::Node& beam : root["beams"]) {
      if (beam["ring"].as<std::size_t>() != result.beams.size()) throw std::runtime_error("its beams aren't in order");
      BeamCalibration b;
      b.range_offset = 1e-3 * beam["range_mm"].as<double>();
      b.range_sigma = 1e-3 * beam["range_sigma_mm"].as<double>();
      b.range_applied = beam["range_applied"].as<bool>();
      b.elevation_offset = degree * beam["elevation_deg"].as<double>();
      b.elevation_sigma = degree * beam["elevation_sigma_deg"].as<double>();
      b.elevation_applied = beam["elevation_applied"].as<bool>();
      if (!(std::abs(b.range_offset) <= most_range) || !(std::abs(b.elevation_offset) <= most_elevation)) {
        throw std::runtime_error("the offsets of ring " + std::to_string(result.beams.size()) + " are no sensor's");
      }
      result.beams.push_back(b);
    }
    if (result.beams.empty()) throw std::runtime_error("it holds no beams");
    return result;
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + ": is no calibration (" + error.msg + ")");
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": is no calibration: " + error.what());
  }
}

}  // namespace sgraph
