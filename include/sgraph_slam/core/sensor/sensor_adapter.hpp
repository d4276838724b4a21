#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/sensor/description.hpp"
#include "sgraph_slam/core/sensor/params.hpp"
#include "sgraph_slam/core/sensor/raw_scan.hpp"
#include "sgraph_slam/core/sensor/ring_table.hpp"

namespace sgraph {

/// Why a cloud is of no use to anybody.
enum class RawFault { none, times, beams };

/// What came of one raw cloud.
struct AdaptedScans {
  std::vector<CloudPtr> scans;  ///< whole turns, in order; none while the sensor is being recognised or a turn is being put together
  RawFault fault = RawFault::none;
  std::string text;  ///< one sentence about the fault
};

/// Brings a driver's clouds, whatever their conventions, into the package's: whole turns, each point with its time in seconds from the cloud's stamp
/// and the number of its beam. Recognises the conventions from the first clouds and keeps to them. Deterministic; one caller.
class SensorAdapter {
 public:
  explicit SensorAdapter(const SensorParams& params) : params_(params) {}

  /// Shows a cloud without taking it: a recording may be looked into ahead of time.
  void look(const RawScan& raw);
  /// Nothing more will be shown: decides.
  void settle();

  /// Takes the next cloud. The first ones are held until the conventions are known, at most for `most_held` clouds or a second.
  AdaptedScans take(RawScan raw);
  /// Hands out what is held; decides with what has been seen.
  AdaptedScans flush();

  [[nodiscard]] bool decided() const { return decided_; }
  [[nodiscard]] const SensorDescription& description() const { return description_; }

  static constexpr std::size_t most_held = 60;

 private:
  /// What one cloud shows of its conventions.
  struct Look {
    Stamp stamp;
    std::optional<double> lag;  // from stamp to reception [s]
    double begin = 0, end = 0;  // azimuth of its first and last firing [rad]
    double swept = 0;           // from the first to the last firing, positive counter-clockwise [rad]; 0: not in order
    double coverage = 0;        // [rad]
    double step = 0;            // between firings of the same laser [rad]
    bool by_ring = false;       // points are ordered ring by ring
    int points = 0;
    double time_span = 0;   // in the field's unit; 0: all the same
    double time_first = 0;  // smallest value
    double time_trend = 0;  // correlation with the order in the message
    bool sharp = false;     // as the sensor saw it
  };

  [[nodiscard]] static Look look_at(const RawScan& raw, const std::optional<RingTable>& table);
  [[nodiscard]] bool enough() const;
  void decide();
  void decide_rings();
  [[nodiscard]] std::optional<RingTable> agreed_table(std::optional<RingTable> (*learn)(const Cloud&), bool by_field) const;
  void decide_slices();
  void decide_times();
  void decide_turn();
  AdaptedScans adapt(RawScan raw);
  void number_rings(RawScan& raw) const;
  [[nodiscard]] bool on_beams(const RawScan& raw) const;
  bool set_times(RawScan& raw, std::string& error) const;
  void times_from_azimuth(Cloud& cloud) const;
  void join(Cloud cloud, std::vector<CloudPtr>& scans);

  SensorParams params_;
  SensorDescription description_;
  bool decided_ = false;
  std::vector<Look> looks_;
  std::optional<RawScan> sample_;  // of the points of the first clouds; the rest is the first one's
  std::vector<RawScan> shown_;     // whole turns
  std::optional<RingTable> table_;
  int refused_ = 0;            // clouds in a row that lie on none of the beams
  double time_scale_ = 1;      // seconds a unit of the field, negative when it counts backwards
  double turn_sign_ = 0;       // +1 counter-clockwise
  double stamp_fraction_ = 1;  // of the turn that has passed at the stamp, for times from the azimuth
  std::deque<RawScan> held_;
  Cloud joined_;             // the turn being put together; its points' times count from its stamp
  double joined_sweep_ = 0;  // [rad]
  double joined_end_ = 0;    // azimuth of its last firing [rad]
};

}  // namespace sgraph
