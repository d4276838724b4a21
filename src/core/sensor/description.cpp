#include "sgraph_slam/core/sensor/description.hpp"

#include <array>
#include <cstdio>

namespace sgraph {
namespace {

std::string number(const char* pattern, double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), pattern, value);
  return text.data();
}

}  // namespace

std::string SensorDescription::text() const {
  std::string line = "sensor: " + model;
  if (rings > 0 && model.find("rings") == std::string::npos) line += ", " + std::to_string(rings) + " rings";
  if (rings > 0) {
    line += " from " + number("%.2f", elevations_deg.front()) + " to " + number("%.2f", elevations_deg.back()) + " deg (by " +
            (ring_source == "field" ? "field ring" : "elevation") + "), vertical offsets " + vertical_offsets;
  }
  if (sweep != "unknown") line += ", turns " + sweep;
  if (turn > 0) line += " in " + number("%.4f", turn) + " s";
  if (slices) line += ", clouds of " + number("%.0f", coverage_deg) + " deg each are joined to turns";
  if (time_source == "none") {
    line += "; points without times";
  } else {
    line += "; times from " + (time_source == "azimuth" ? std::string("the azimuth") : time_source);
    if (!time_unit.empty()) line += " in " + time_unit;
    if (!time_origin.empty()) line += " (" + time_origin + ")";
    line += ", stamp " + (stamp == "inside" ? std::string("inside the turn") : "at the " + stamp + " firing");
  }
  if (!intensity) line += "; no intensity";
  return line;
}

}  // namespace sgraph
