#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/sensor/description.hpp"
#include "sgraph_slam/core/sensor/params.hpp"
#include "sgraph_slam/core/sensor/raw_scan.hpp"
#include "sgraph_slam/core/sensor/recognition.hpp"
#include "sgraph_slam/core/sensor/slice_joiner.hpp"

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

  /// Takes the next cloud. The first ones are held until the conventions are known, at most for `SensorRecognition::most_looks` clouds or a second.
  AdaptedScans take(RawScan raw);
  /// Hands out what is held; decides with what has been seen.
  AdaptedScans flush();

  [[nodiscard]] bool decided() const { return decided_; }
  [[nodiscard]] const SensorDescription& description() const { return conventions_.description; }

 private:
  AdaptedScans adapt(RawScan raw);
  void number_rings(RawScan& raw) const;
  [[nodiscard]] bool on_beams(const RawScan& raw) const;
  bool set_times(RawScan& raw, std::string& error) const;

  SensorParams params_;
  SensorRecognition recognition_{params_};
  SensorConventions conventions_;
  bool decided_ = false;
  int refused_ = 0;           // clouds in a row that lie on none of the beams
  std::deque<RawScan> held_;  // until the conventions are known
  std::optional<SliceJoiner> joiner_;
};

}  // namespace sgraph
