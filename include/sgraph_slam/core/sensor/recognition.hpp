#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "sgraph_slam/core/sensor/cloud_look.hpp"
#include "sgraph_slam/core/sensor/description.hpp"
#include "sgraph_slam/core/sensor/params.hpp"
#include "sgraph_slam/core/sensor/raw_scan.hpp"
#include "sgraph_slam/core/sensor/ring_table.hpp"

namespace sgraph {

/// The conventions of a driver's clouds, as they are told to the user and as they are applied.
struct SensorConventions {
  SensorDescription description;
  std::optional<RingTable> table;  ///< the sensor's beams, when they are known
  double time_scale = 1;           ///< seconds a unit of the field of times, negative when it counts backwards
  double turn_sign = 0;            ///< +1 counter-clockwise, -1 clockwise; 0 unknown
  double stamp_fraction = 1;       ///< of the turn that has passed at the stamp, for times from the azimuth
};

/// Recognises the conventions from the first clouds of a sensor. Deterministic; one caller.
class SensorRecognition {
 public:
  explicit SensorRecognition(const SensorParams& params) : params_(params) {}

  /// Looks at a cloud. Returns false when it shows nothing: it has next to no points.
  bool look(const RawScan& raw);
  /// Whether what was looked at tells all that can be told.
  [[nodiscard]] bool enough() const;
  /// Whether there was anything to look at.
  [[nodiscard]] bool has_seen_any() const { return !looks_.empty(); }
  /// The conventions by what was seen, or as the parameters demand. To be called once.
  SensorConventions decide();

  /// Clouds after which nothing more is to be learnt.
  static constexpr std::size_t most_looks = 60;

 private:
  void decide_rings();
  [[nodiscard]] std::optional<RingTable> agreed_table(std::optional<RingTable> (*learn)(const Cloud&), bool by_field) const;
  void decide_slices();
  void decide_turn();
  void decide_stamp();
  void decide_times();
  [[nodiscard]] bool decide_time_field();

  SensorParams params_;
  std::vector<CloudLook> looks_;
  std::optional<RawScan> sample_;  // of the points of the first clouds; the rest is the first one's
  std::vector<RawScan> shown_;     // whole turns
  std::optional<RingTable> table_;
  SensorConventions result_;
};

}  // namespace sgraph
