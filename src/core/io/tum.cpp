#include "sgraph_slam/core/io/tum.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace sgraph {
namespace {

std::optional<double> number_from(const std::string& word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return {};
  return value;
}

// A double holds present-day stamps to 0.2 microseconds only, so the digits are read as whole seconds and nanoseconds.
std::optional<Stamp> stamp_from(const std::string& word) {
  const auto dot = word.find('.');
  if (word.find_first_not_of("0123456789.") != std::string::npos || dot == 0) {
    const auto value = number_from(word);  // exponents, signs
    return value && std::abs(*value) < 9e9 ? std::optional(Stamp::from_seconds(*value)) : std::nullopt;
  }
  std::string fraction = dot == std::string::npos ? "" : word.substr(dot + 1);
  if (fraction.find('.') != std::string::npos) return {};
  fraction.resize(9, '0');
  std::int64_t seconds = 0;
  std::int64_t nanoseconds = 0;
  const std::string whole = word.substr(0, dot);
  if (std::from_chars(whole.data(), whole.data() + whole.size(), seconds).ec != std::errc() || seconds > 9'000'000'000) return {};
  std::from_chars(fraction.data(), fraction.data() + fraction.size(), nanoseconds);
  return Stamp{seconds * 1'000'000'000 + nanoseconds};
}

// Nothing when the line isn't a pose.
std::optional<StampedPose> pose_from(const std::string& line) {
  std::istringstream words(line);
  std::string word;
  if (!(words >> word)) return {};
  const auto stamp = stamp_from(word);
  if (!stamp) return {};
  std::array<double, 7> v{};
  for (double& value : v) {
    if (!(words >> word)) return {};
    const auto read = number_from(word);
    if (!read) return {};
    value = *read;
  }
  if (words >> word) return {};
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (std::abs(q.norm() - 1) > 1e-2) return {};
  return StampedPose{*stamp, Pose{q.normalized(), {v[0], v[1], v[2]}}};
}

}  // namespace

Trajectory read_tum(std::istream& in, const std::string& name) {
  Trajectory trajectory;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto where = name + ":" + std::to_string(number) + ": ";
    const auto pose = pose_from(line);
    if (!pose) throw std::runtime_error(where + "expected 'stamp x y z qx qy qz qw' with finite numbers and a unit quaternion");
    if (!trajectory.empty() && pose->stamp <= trajectory.back().stamp) throw std::runtime_error(where + "stamps must increase");
    trajectory.push_back(*pose);
  }
  return trajectory;
}

Trajectory read_tum(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  return read_tum(in, path);
}

void write_tum(const Trajectory& trajectory, std::ostream& out) {
  std::array<char, 256> line{};
  for (const StampedPose& s : trajectory) {
    const Eigen::Vector3d& t = s.pose.translation;
    const Eigen::Quaterniond& q = s.pose.rotation;
    std::snprintf(line.data(), line.size(), "%lld.%09lld %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n",
                  static_cast<long long>(s.stamp.nanoseconds / 1'000'000'000), static_cast<long long>(s.stamp.nanoseconds % 1'000'000'000), t.x(),
                  t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
    out << line.data();
  }
}

void write_tum(const Trajectory& trajectory, const std::string& path) {
  std::ofstream out(path);
  write_tum(trajectory, out);
  out.close();
  if (!out) throw std::runtime_error("cannot write " + path);
}

}  // namespace sgraph
