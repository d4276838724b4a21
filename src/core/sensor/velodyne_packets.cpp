#include "sgraph_slam/core/sensor/velodyne_packets.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/sensor/ring_table.hpp"

namespace sgraph {
namespace {

constexpr int blocks = 12;
constexpr int lasers_in_block = 32;
constexpr std::size_t block_size = 100;  // [bytes]
constexpr std::size_t stamp_at = 1200;   // [bytes] microseconds since the hour
constexpr std::size_t mode_at = 1204;
constexpr std::size_t product_at = 1205;
constexpr std::uint8_t dual_return = 0x39;
constexpr double range_unit = 0.002;  // [m]
constexpr double hour = 3600.0;       // [s]

struct Product {
  std::uint8_t number;
  const char* model;
  int lasers;              // that fire one after the other
  double laser_interval;   // [s]
  double firing_interval;  // of all lasers [s]
  double lowest, step;     // elevation of the lowest ring and from ring to ring [deg]
  std::array<int, lasers_in_block> ring_of_laser;
};

constexpr std::array<int, lasers_in_block> rings_of_16{0, 8, 1, 9, 2, 10, 3, 11, 4, 12, 5, 13, 6, 14, 7, 15};
constexpr std::array<int, lasers_in_block> rings_of_32{0, 16, 1, 17, 2,  18, 3,  19, 4,  20, 5,  21, 6,  22, 7,  23,
                                                       8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31};
constexpr std::array<Product, 3> products{{
    {0x22, "VLP-16", 16, 2.304e-6, 55.296e-6, -15, 2, rings_of_16},
    {0x24, "VLP-16 Hi-Res", 16, 2.304e-6, 55.296e-6, -10, 4.0 / 3, rings_of_16},
    {0x21, "HDL-32E", 32, 1.152e-6, 46.08e-6, -92.0 / 3, 4.0 / 3, rings_of_32},
}};

const Product* product_of(std::uint8_t number) {
  const auto found = std::find_if(products.begin(), products.end(), [number](const Product& p) { return p.number == number; });
  return found != products.end() ? &*found : nullptr;
}

int word(const VelodynePacket& packet, std::size_t at) { return packet.data[at] | packet.data[at + 1] << 8; }

double clock_of(const VelodynePacket& packet) {
  return 1e-6 * (static_cast<double>(word(packet, stamp_at)) + 65536.0 * static_cast<double>(word(packet, stamp_at + 2)));
}

bool is_data(const VelodynePacket& packet) {
  for (std::size_t block = 0; block < blocks; ++block) {
    if (word(packet, block * block_size) != 0xEEFF) return false;
  }
  return true;
}

// Time of each packet's first firing from `stamp` [s]: by the sensor's clock where that agrees with the packets' stamps to a few milliseconds, which
// leaves out the jitter of network and computer.
std::vector<double> packet_times(const std::vector<const VelodynePacket*>& packets, Stamp stamp) {
  std::vector<double> times;
  const double to_first = std::abs(packets.front()->stamp - stamp);
  const double to_last = std::abs(packets.back()->stamp - stamp);
  const VelodynePacket& reference = to_first < to_last ? *packets.front() : *packets.back();
  for (const VelodynePacket* packet : packets) {
    const double by_clock = std::remainder(clock_of(*packet) - clock_of(reference), hour);
    const double by_stamp = packet->stamp - reference.stamp;
    times.push_back(std::abs(by_clock - by_stamp) < 0.05 ? by_clock : by_stamp);
  }
  return times;
}

class Decoder {
 public:
  Decoder(const Product& product, bool dual, bool vertical_offsets, RawScan& scan) : product_(product), dual_(dual), scan_(scan) {
    for (int ring = 0; ring < product.lasers; ++ring) {
      const double elevation = (product.lowest + product.step * ring) * M_PI / 180;
      cos_.push_back(std::cos(elevation));
      sin_.push_back(std::sin(elevation));
    }
    if (vertical_offsets && product.number == 0x22) offsets_ = vlp16_vertical_offsets();
    offsets_.resize(static_cast<std::size_t>(product.lasers), 0.0);
  }

  void decode(const VelodynePacket& packet, double time) {
    const int per_azimuth = dual_ ? 2 : 1;  // blocks
    const int sequences = lasers_in_block / product_.lasers;
    for (int block = 0; block < blocks; ++block) {
      const double azimuth = azimuth_at(packet, block);
      const int next = block + per_azimuth < blocks ? block : block - per_azimuth;
      double turned = azimuth_at(packet, next + per_azimuth) - azimuth_at(packet, next);
      turned -= 2 * M_PI * std::floor(turned / (2 * M_PI));
      const double began = block / per_azimuth * sequences * product_.firing_interval;
      for (int n = 0; n < lasers_in_block; ++n) {
        const double in_block = n / product_.lasers * product_.firing_interval + n % product_.lasers * product_.laser_interval;
        const std::size_t at = return_at(block, n);
        const int distance = word(packet, at);
        if (distance == 0 || (dual_ && block % 2 == 1 && distance == word(packet, return_at(block - 1, n)))) continue;
        const int ring = product_.ring_of_laser[static_cast<std::size_t>(n % product_.lasers)];
        add(ring, range_unit * distance, azimuth + turned * in_block / (sequences * product_.firing_interval), packet.data[at + 2],
            time + began + in_block);
      }
    }
  }

 private:
  static double azimuth_at(const VelodynePacket& packet, int block) {
    return word(packet, static_cast<std::size_t>(block) * block_size + 2) * M_PI / 18000;
  }
  static std::size_t return_at(int block, int laser) {
    return static_cast<std::size_t>(block) * block_size + 4 + 3 * static_cast<std::size_t>(laser);
  }

  void add(int ring, double range, double azimuth, std::uint8_t intensity, double time) {
    const auto row = static_cast<std::size_t>(ring);
    Point point;
    point.x = static_cast<float>(range * cos_[row] * std::cos(azimuth));
    point.y = static_cast<float>(-range * cos_[row] * std::sin(azimuth));
    point.z = static_cast<float>(range * sin_[row] + offsets_[row]);
    point.intensity = intensity;
    point.ring = static_cast<std::uint16_t>(ring);
    scan_.cloud.points.push_back(point);
    scan_.times.push_back(time);
  }

  const Product& product_;
  bool dual_;
  RawScan& scan_;
  std::vector<double> cos_, sin_, offsets_;  // by ring
};

}  // namespace

DecodedPackets decode_velodyne(const std::vector<VelodynePacket>& packets, Stamp stamp, bool vertical_offsets) {
  DecodedPackets result;
  result.scan.cloud.stamp = stamp;
  result.scan.time_field = "of the packets";
  result.scan.has_ring = true;
  result.scan.has_intensity = true;
  std::vector<const VelodynePacket*> usable;
  const Product* product = nullptr;
  for (const VelodynePacket& packet : packets) {
    const Product* own = is_data(packet) ? product_of(packet.data[product_at]) : nullptr;
    if (own != nullptr && product == nullptr) product = own;
    if (own != nullptr && own == product) usable.push_back(&packet);
  }
  result.skipped = static_cast<int>(packets.size() - usable.size());
  if (usable.empty()) {
    result.error = packets.empty()            ? "the message holds no packets"
                   : is_data(packets.front()) ? "packets of product " + std::to_string(packets.front().data[product_at]) +
                                                    " can't be decoded (VLP-16, VLP-16 Hi-Res and HDL-32E can)"
                                              : "the packets are no Velodyne data packets";
    return result;
  }
  result.model = product->model;
  result.dual = usable.front()->data[mode_at] == dual_return;
  const std::vector<double> times = packet_times(usable, stamp);
  Decoder decoder(*product, result.dual, vertical_offsets, result.scan);
  for (std::size_t i = 0; i < usable.size(); ++i) decoder.decode(*usable[i], times[i]);
  return result;
}

}  // namespace sgraph
