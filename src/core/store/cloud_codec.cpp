#include "sgraph_slam/core/store/cloud_codec.hpp"

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "bytes.hpp"

namespace sgraph {
namespace {

constexpr std::uint32_t version = 1;
constexpr double time_resolution = 1e-5;  // [s]
constexpr double farthest = 2e6;          // [m] that the numbers hold
constexpr double full_scale = 65535;      // of an intensity
constexpr std::uint32_t most_points = 1u << 26;

std::uint32_t zigzag(std::int32_t value) { return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31); }
std::int32_t unzigzag(std::uint32_t value) { return static_cast<std::int32_t>((value >> 1) ^ (~(value & 1) + 1)); }

// A column of numbers as differences from the last, its lowest bytes first, then the next ones: these are nearly all zero.
void write_column(const std::vector<std::int32_t>& values, ByteWriter& out) {
  std::string planes(4 * values.size(), '\0');
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint32_t delta = zigzag(static_cast<std::int32_t>(static_cast<std::uint32_t>(values[i]) - last));
    last = static_cast<std::uint32_t>(values[i]);
    for (std::size_t b = 0; b < 4; ++b) planes[b * values.size() + i] = static_cast<char>((delta >> (8 * b)) & 0xff);
  }
  out.bytes(planes);
}

std::vector<std::int32_t> read_column(std::size_t count, ByteReader& in) {
  const std::string_view planes = in.bytes(4 * count);
  std::vector<std::int32_t> values(count);
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t delta = 0;
    for (std::size_t b = 0; b < 4; ++b) delta |= static_cast<std::uint32_t>(static_cast<unsigned char>(planes[b * count + i])) << (8 * b);
    last += static_cast<std::uint32_t>(unzigzag(delta));
    values[i] = static_cast<std::int32_t>(last);
  }
  return values;
}

bool storable(const Point& p) { return p.position().allFinite() && p.position().cwiseAbs().maxCoeff() < farthest; }

// What an intensity is multiplied with: 1 where all are whole numbers that fit.
float intensity_scale(const std::vector<const Point*>& points) {
  bool whole = true;
  float most = 0;
  for (const Point* p : points) {
    if (!std::isfinite(p->intensity)) continue;
    most = std::max(most, std::abs(p->intensity));
    whole = whole && p->intensity == std::round(p->intensity);
  }
  return most == 0 || (whole && most <= full_scale) ? 1.0F : static_cast<float>(full_scale) / most;
}

std::int32_t rounded(double value) {
  return std::isfinite(value) ? static_cast<std::int32_t>(std::lround(std::min(std::max(value, -2.1e9), 2.1e9))) : 0;
}

}  // namespace

std::string encode_cloud(const Cloud& cloud) {
  std::vector<const Point*> points;
  points.reserve(cloud.size());
  for (const Point& p : cloud.points) {
    if (storable(p)) points.push_back(&p);
  }
  const float scale = intensity_scale(points);
  ByteWriter out;
  out.value(version);
  out.value(cloud.stamp.nanoseconds);
  out.value(static_cast<std::uint32_t>(cloud.frame.size()));
  out.bytes(cloud.frame);
  out.value(static_cast<std::uint32_t>(cloud.viewpoints.size()));
  for (const Viewpoint& v : cloud.viewpoints) {
    out.value(v.time);
    for (int k = 0; k < 3; ++k) out.value(v.position[k]);
  }
  out.value(static_cast<std::uint32_t>(points.size()));
  out.value(scale);
  const auto column = [&](auto number) {
    std::vector<std::int32_t> values;
    values.reserve(points.size());
    for (const Point* p : points) values.push_back(number(*p));
    write_column(values, out);
  };
  column([](const Point& p) { return rounded(p.x / stored_resolution); });
  column([](const Point& p) { return rounded(p.y / stored_resolution); });
  column([](const Point& p) { return rounded(p.z / stored_resolution); });
  column([scale](const Point& p) { return rounded(static_cast<double>(p.intensity) * scale); });
  column([](const Point& p) { return rounded(p.time / time_resolution); });
  column([](const Point& p) { return static_cast<std::int32_t>(p.ring); });
  return compressed(out.take());
}

Cloud decode_cloud(std::string_view bytes) {
  const std::string raw = decompressed(bytes);
  ByteReader in(raw);
  if (in.value<std::uint32_t>() != version) throw std::runtime_error("a cloud of an unknown version");
  Cloud cloud;
  cloud.stamp.nanoseconds = in.value<std::int64_t>();
  cloud.frame = std::string(in.bytes(in.value<std::uint32_t>()));
  const auto viewpoints = in.value<std::uint32_t>();
  for (std::uint32_t i = 0; i < viewpoints; ++i) {
    Viewpoint v;
    v.time = in.value<double>();
    for (int k = 0; k < 3; ++k) v.position[k] = in.value<double>();
    if (!std::isfinite(v.time) || !v.position.allFinite()) throw std::runtime_error("a damaged cloud");
    cloud.viewpoints.push_back(v);
  }
  const auto count = in.value<std::uint32_t>();
  if (count > most_points) throw std::runtime_error("a damaged cloud");
  const auto scale = in.value<float>();
  if (!(scale > 0) || !std::isfinite(scale)) throw std::runtime_error("a damaged cloud");
  const auto x = read_column(count, in);
  const auto y = read_column(count, in);
  const auto z = read_column(count, in);
  const auto intensity = read_column(count, in);
  const auto time = read_column(count, in);
  const auto ring = read_column(count, in);
  cloud.points.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    Point& p = cloud.points[i];
    p.x = static_cast<float>(x[i] * stored_resolution);
    p.y = static_cast<float>(y[i] * stored_resolution);
    p.z = static_cast<float>(z[i] * stored_resolution);
    p.intensity = static_cast<float>(intensity[i]) / scale;
    p.time = static_cast<float>(time[i] * time_resolution);
    p.ring = static_cast<std::uint16_t>(ring[i]);
  }
  return cloud;
}

}  // namespace sgraph
