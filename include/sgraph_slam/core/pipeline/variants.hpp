#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/front_end.hpp"
#include "sgraph_slam/core/pipeline/run.hpp"

namespace sgraph {

/// One way to map a recording.
struct Variant {
  std::string name;
  Params params;
  Stage until = Stage::mapping;
  bool encoders = false;  ///< gets the robot's odometry
  bool imu = false;       ///< gets the inertial readings
};

/// "NAME" or "NAME:key=value,key=value": a variant of what is common to all. Keys are parameters, and `until` (a stage), `encoders` and `imu`
/// (true, false; `encoders` is true with `odometry.source=topic` unless given). Throws ParamError that names the variant; a name is of letters,
/// digits and _ - only, since it names a folder.
Variant parse_variant(const std::string& text, const ParamValues& common, const Variant& base = {});

/// Maps one recording in several ways at once. What variants have in common is done once: scans are read or simulated once, those with the same
/// parameters of prefilter and odometry share the motion, the keyframes and their clouds, and those with the same segmentation too share the
/// planes. Each gives to the last bit what it gives alone, and is charged for a shared stage as if it had run it alone. One thread.
class VariantSet {
 public:
  /// Throws std::runtime_error when two have the same name, and what the stages' constructors throw at bad parameters. `start`: the map that each
  /// takes up, if any.
  VariantSet(std::vector<Variant> variants, const Pose& T_base_lidar, const SessionStart& start = {});

  /// Shows the map of one variant to an observer as it grows (see BackEnd).
  void observe(std::size_t variant, MapObserver* observer) { runs_.at(variant).observe(observer); }

  void add(const OdometrySample& sample);
  void add(const ImuSample& sample);
  void process(const Cloud& raw);
  void finish();

  [[nodiscard]] const std::vector<Variant>& variants() const { return variants_; }
  /// In the order of the variants.
  [[nodiscard]] const std::deque<Run>& runs() const { return runs_; }
  /// How often a scan is registered: the number of different front ends.
  [[nodiscard]] std::size_t front_ends() const { return fronts_.size(); }
  /// What the variant knows of the LiDAR's beams. Never null.
  [[nodiscard]] std::shared_ptr<const RingCalibration> calibration(std::size_t variant) const;

 private:
  // Variants that see the same planes. Those that stop before have no segmenter.
  struct Segmentation {
    std::string key;
    std::optional<PlaneSegmenter> segmenter;
    std::vector<std::size_t> runs;
  };
  struct Front {
    std::string key;
    bool encoders, imu;
    FrontEnd front_end;
    std::vector<Segmentation> segmentations;
  };
  template <class Take>
  void hand_on(const Front& front, const MeasuredScan& scan, Take take);

  std::vector<Variant> variants_;
  std::deque<Run> runs_;
  std::deque<Front> fronts_;
};

}  // namespace sgraph
