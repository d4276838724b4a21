#include "sgraph_slam/core/sensor/ring_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

constexpr double degree = M_PI / 180;
constexpr double least_distance = 0.3;  // [m] from the axis; nearer points are the robot, and tell no angle
constexpr int least_points = 10;        // of a ring that counts
constexpr double sharp_residual =
    0.003;  // [m] coordinates are rounded to millimetres by some drivers; motion within a turn moves points by centimetres
constexpr double one_point_wobble = 1e-5;  // [rad] coordinates in float32 are good to 1e-7
constexpr double cluster_distance = 0.8;   // [m] from the axis at which origins that lie apart by a centimetre no longer blur the elevations
constexpr double cluster_bin = 0.02 * degree;
constexpr int cluster_gap = 3;  // empty bins between clusters

double distance_of(const Point& p) { return std::hypot(static_cast<double>(p.x), static_cast<double>(p.y)); }
bool tells(const Point& p, double least) {
  const double rho = distance_of(p);
  return std::isfinite(rho) && std::isfinite(p.z) && rho > least;
}

// Sums of a straight line z = slope * rho + offset, and of the elevation seen from the origin.
struct ConeSums {
  double n = 0, rho = 0, z = 0, rho2 = 0, rho_z = 0, z2 = 0, angle = 0, angle2 = 0;
  void add(double r, double h) {
    const double a = std::atan2(h, r);
    n += 1, rho += r, z += h, rho2 += r * r, rho_z += r * h, z2 += h * h, angle += a, angle2 += a * a;
  }
  [[nodiscard]] RingCone cone() const {
    RingCone result;
    result.points = static_cast<int>(n);
    const double spread = rho2 - rho * rho / n;
    // Points all at one distance tell one number only.
    const bool line = spread > n * 0.05 * 0.05;
    result.slope = line ? (rho_z - rho * z / n) / spread : rho_z / rho2;
    result.offset = line ? (z - result.slope * rho) / n : 0.0;
    const double squares = z2 + result.slope * result.slope * rho2 + n * result.offset * result.offset - 2 * result.slope * rho_z -
                           2 * result.offset * z + 2 * result.slope * result.offset * rho;
    result.residual = std::sqrt(std::max(0.0, squares / n));
    result.wobble = std::sqrt(std::max(0.0, angle2 / n - angle / n * angle / n));
    return result;
  }
};

void judge_sharpness(const std::vector<std::vector<std::pair<double, double>>>& rows, RingTable& table) {
  std::vector<double> residuals;
  std::vector<double> wobbles;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (rows[row].empty()) continue;
    // Sums of squares lose the micrometres; the second pass doesn't.
    double sum = 0, angle = 0;
    for (const auto& [rho, z] : rows[row])
      sum += std::pow(z - table.cones[row].slope * rho - table.cones[row].offset, 2), angle += std::atan2(z, rho);
    const auto n = static_cast<double>(rows[row].size());
    double wobble = 0;
    for (const auto& [rho, z] : rows[row]) wobble += std::pow(std::atan2(z, rho) - angle / n, 2);
    table.cones[row].residual = std::sqrt(sum / n);
    table.cones[row].wobble = std::sqrt(wobble / n);
    residuals.push_back(table.cones[row].residual);
    wobbles.push_back(table.cones[row].wobble);
  }
  if (residuals.empty()) return;
  table.sharp = upper_median(residuals) < sharp_residual;
  table.from_one_point = upper_median(wobbles) < one_point_wobble;
}

struct KnownSensor {
  const char* name;
  std::vector<double> elevations;  // [deg]
  double tolerance;                // [deg] mean deviation
};

std::vector<double> steps(double first, double step, int count) {
  std::vector<double> angles;
  for (int i = 0; i < count; ++i) angles.push_back(first + step * i);
  return angles;
}

// User manuals: Velodyne 63-9243 (VLP-16, Puck LITE), 63-9318 (Hi-Res), 63-9325 (VLP-32C), 63-9113 (HDL-32E); Hesai PandarXT (XT-32, XT-16); RS-16
// has the angles of the VLP-16.
const std::vector<KnownSensor>& known_sensors() {
  static const std::vector<KnownSensor> sensors{
      {"VLP-16", steps(-15, 2, 16), 0.15},
      {"VLP-16 Hi-Res", steps(-10, 4.0 / 3, 16), 0.1},
      {"VLP-32C",
       {-25,    -15.639, -11.31, -8.843, -7.254, -6.148, -5.333, -4.667, -4,    -3.667, -3.333, -3,    -2.667, -2.333, -2,     -1.667,
        -1.333, -1,      -0.667, -0.333, 0,      0.333,  0.667,  1,      1.333, 1.667,  2.333,  3.333, 4.667,  7,      10.333, 15},
       0.08},
      {"HDL-32E", steps(-30.67, 1.334, 32), 0.1},
      {"XT-32", steps(-16, 1, 32), 0.1},
  };
  return sensors;
}

bool matches(const RingTable& table, const KnownSensor& sensor) {
  if (table.cones.size() != sensor.elevations.size()) return false;
  double sum = 0;
  for (std::size_t i = 0; i < table.cones.size(); ++i) {
    const double deviation = std::abs(std::atan(table.cones[i].slope) / degree - sensor.elevations[i]);
    if (deviation > 4 * sensor.tolerance) return false;
    sum += deviation;
  }
  return sum < sensor.tolerance * static_cast<double>(table.cones.size());
}

// Distance from the axis at which the beams of a sensor with its origins apart cross: offset = -distance * slope. 0 when they don't.
double crossing_distance(const RingTable& table) {
  double slope_offset = 0, slope2 = 0;
  for (const RingCone& cone : table.cones) {
    slope_offset += cone.slope * cone.offset;
    slope2 += cone.slope * cone.slope;
  }
  return slope2 > 0 ? -slope_offset / slope2 : 0;
}

// Angles of Ouster's sensors are measured one by one; their span and even spacing are what they share.
std::string ouster_of(const RingTable& table) {
  const int rows = table.rows();
  if (rows != 16 && rows != 32 && rows != 64 && rows != 128) return "";
  const double low = std::atan(table.cones.front().slope) / degree;
  const double high = std::atan(table.cones.back().slope) / degree;
  if (std::abs(low + high) > 4) return "";
  for (std::size_t i = 0; i + 1 < table.cones.size(); ++i) {
    const double step = (std::atan(table.cones[i + 1].slope) - std::atan(table.cones[i].slope)) / degree;
    if (std::abs(step * (rows - 1) / (high - low) - 1) > 0.5) return "";
  }
  const std::string name = std::abs(high - 45) < 3                                  ? "OS0"
                           : std::abs(high - 21) < 2 || std::abs(high - 16.6) < 1.5 ? "OS1"
                           : std::abs(high - 11) < 1                                ? "OS2"
                                                                                    : "";
  return name.empty() ? "" : name + "-" + std::to_string(rows);
}

}  // namespace

int RingTable::nearest_row(const Point& point) const {
  if (cones.empty()) return -1;
  const double rho = distance_of(point);
  const double z = static_cast<double>(point.z);
  if (!(rho > 0)) return z > 0 ? rows() - 1 : 0;
  const auto above = std::lower_bound(cones.begin(), cones.end(), z / rho, [](const RingCone& cone, double slope) { return cone.slope < slope; });
  const auto index = static_cast<int>(above - cones.begin());
  int best = -1;
  double least = 0;
  for (int row = std::max(0, index - 2); row <= std::min(rows() - 1, index + 1); ++row) {
    const RingCone& cone = cones[static_cast<std::size_t>(row)];
    const double away = std::abs(z - cone.slope * rho - cone.offset);
    if (best >= 0 && away >= least) continue;
    best = row;
    least = away;
  }
  return best;
}

std::optional<RingTable> table_by_ring(const Cloud& cloud) {
  std::vector<ConeSums> sums;
  double all = 0, in_rings = 0;
  for (const Point& p : cloud.points) {
    if (!tells(p, least_distance)) continue;
    ++all;
    if (p.ring >= 1024) continue;
    if (p.ring >= sums.size()) sums.resize(std::size_t{p.ring} + 1);
    sums[p.ring].add(distance_of(p), static_cast<double>(p.z));
  }
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t ring = 0; ring < sums.size(); ++ring) {
    if (sums[ring].n < least_points) continue;
    order.emplace_back(sums[ring].cone().slope, ring);
    in_rings += sums[ring].n;
  }
  if (order.size() < 2 || in_rings < 0.8 * all) return std::nullopt;  // numbers of something else
  std::sort(order.begin(), order.end());
  RingTable table;
  table.row_of_ring.assign(sums.size(), -1);
  for (const auto& [slope, ring] : order) {
    table.row_of_ring[ring] = table.rows();
    table.cones.push_back(sums[ring].cone());
  }
  std::vector<std::vector<std::pair<double, double>>> rows(table.cones.size());
  for (const Point& p : cloud.points) {
    if (!tells(p, least_distance) || p.ring >= table.row_of_ring.size() || table.row_of_ring[p.ring] < 0) continue;
    rows[static_cast<std::size_t>(table.row_of_ring[p.ring])].emplace_back(distance_of(p), static_cast<double>(p.z));
  }
  judge_sharpness(rows, table);
  return table;
}

std::optional<RingTable> table_by_elevation(const Cloud& cloud) {
  constexpr auto bins = static_cast<std::size_t>(M_PI / cluster_bin) + 2;
  std::vector<int> histogram(bins, 0);
  int counted = 0;
  for (const Point& p : cloud.points) {
    if (!tells(p, cluster_distance)) continue;
    ++histogram[static_cast<std::size_t>((std::atan2(static_cast<double>(p.z), distance_of(p)) + M_PI / 2) / cluster_bin)];
    ++counted;
  }
  if (counted < 200) return std::nullopt;
  // Clusters: runs of occupied bins with a gap between them.
  struct Run {
    std::size_t first, last;
    int points;
  };
  std::vector<Run> runs;
  for (std::size_t i = 0; i < bins; ++i) {
    if (histogram[i] == 0) continue;
    if (runs.empty() || i - runs.back().last > static_cast<std::size_t>(cluster_gap)) runs.push_back({i, i, 0});
    runs.back().last = i;
    runs.back().points += histogram[i];
  }
  const double usual = static_cast<double>(counted) / static_cast<double>(std::max<std::size_t>(runs.size(), 1));
  runs.erase(std::remove_if(runs.begin(), runs.end(), [&](const Run& run) { return run.points < std::max(0.05 * usual, 5.0); }), runs.end());
  if (runs.size() < 4 || runs.size() > 256) return std::nullopt;
  // What a beam blurs must be less than what lies between two.
  double width = 0;
  for (const Run& run : runs) width += static_cast<double>(run.last - run.first + 1);
  if (width > 0.7 * static_cast<double>(runs.back().last - runs.front().first + 1)) return std::nullopt;

  RingTable table;
  for (const Run& run : runs) {
    RingCone cone;
    cone.slope = std::tan(0.5 * static_cast<double>(run.first + run.last + 1) * cluster_bin - M_PI / 2);
    table.cones.push_back(cone);
  }
  std::vector<std::vector<std::pair<double, double>>> rows;
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<ConeSums> sums(table.cones.size());
    rows.assign(table.cones.size(), {});
    for (const Point& p : cloud.points) {
      if (!tells(p, pass == 0 ? cluster_distance : least_distance)) continue;
      const auto row = static_cast<std::size_t>(table.nearest_row(p));
      sums[row].add(distance_of(p), static_cast<double>(p.z));
      rows[row].emplace_back(distance_of(p), static_cast<double>(p.z));
    }
    for (std::size_t row = 0; row < sums.size(); ++row) {
      if (sums[row].n >= 2) table.cones[row] = sums[row].cone();
    }
    std::sort(table.cones.begin(), table.cones.end(), [](const RingCone& a, const RingCone& b) { return a.slope < b.slope; });
  }
  judge_sharpness(rows, table);
  return table;
}

std::string model_of(const RingTable& table) {
  for (const KnownSensor& sensor : known_sensors()) {
    if (!matches(table, sensor)) continue;
    if (std::string(sensor.name) != "VLP-16") return sensor.name;
    // The RS-16 has the same angles; its beams cross 38 mm in front of the axis (driver: Rx = 0.03825), a VLP-16's at 42 mm.
    const double crossing = crossing_distance(table);
    return !table.from_one_point && crossing > 0.030 && crossing < 0.040 ? "RS-16" : "VLP-16";
  }
  const std::string ouster = ouster_of(table);
  return ouster.empty() ? "unknown, " + std::to_string(table.rows()) + " rings" : ouster;
}

std::optional<double> firing_interval_of(const std::string& model) {
  if (model == "VLP-16" || model == "VLP-16 Hi-Res" || model == "VLP-32C") return 55.296e-6;
  if (model == "HDL-32E") return 46.08e-6;
  if (model == "RS-16") return 100e-6;
  return std::nullopt;
}

const std::vector<double>& vlp16_vertical_offsets() {
  static const std::vector<double> offsets{0.0112,  0.0097,  0.0081,  0.0066,  0.0051,  0.0037,  0.0022,  0.0007,
                                           -0.0007, -0.0022, -0.0037, -0.0051, -0.0066, -0.0081, -0.0097, -0.0112};
  return offsets;
}

}  // namespace sgraph
