#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/math/voxel_index.hpp"
#include "sgraph_slam/core/params/visitor.hpp"
#include "sgraph_slam/core/sensor/ring_calibration.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

struct CalibrationParams {
  std::string mode = "auto";
  std::string vertical = "auto";
  std::string file;
  double range_sigma = 0.0015;
  double elevation_sigma = 0.025;

  void describe(ParamVisitor& v) {
    v.choice(
        "mode", mode, {"estimate", "auto", "fixed", "off"},
        "Errors of the LiDAR's beams: estimate reports and saves them and takes out what `file` holds; auto also takes out the range offsets that it "
        "finds; fixed only takes out what `file` holds.");
    v.field("file", file, "Calibration of an earlier run to begin with; empty: none.");
    v.choice("vertical", vertical, {"auto", "lacking", "present"},
             "Whether the cloud of a VLP-16 lacks the heights of its lasers on the axis. auto: it does when all beams start at one point and their "
             "ranges err as a real sensor's do. lacking: they are added from the first scan; present: never.");
    v.field("range_sigma", range_sigma, "m", {1e-5, 0.1}, "A beam's range offset is taken out when it is known better than this.");
    v.field("elevation_sigma", elevation_sigma, "deg", {1e-4, 1}, "... and its elevation offset when that is known better than this.");
  }
};

/// Estimates a spinning LiDAR's errors beam by beam while it maps: an offset in range (their mean held at zero: a common one can't be told from the
/// size of the building), one in elevation, and whether the cloud lacks the vertical offsets of the lasers (VLP-16). What tells is how the points of
/// different beams, from different places, lie about one plane. Each plane's position and tilt are unknowns of the whole run, and how a scan is off
/// the plane as a whole, by the error of its pose, is an unknown of that scan; both are eliminated from the normal equations. Not thread-safe.
class RingCalibrator {
 public:
  /// Throws std::runtime_error when the file can't be read.
  explicit RingCalibrator(const CalibrationParams& params);

  /// Shows a scan as the sensor saw it, in its own frame: beams are learnt from the first ones. What was found since the last scan is taken out from
  /// this one on.
  void recognise(const Cloud& raw);
  /// What `recognise` has just begun to take out; null when nothing has changed. Scans of before have it still.
  [[nodiscard]] std::shared_ptr<const RingCalibration> added() const { return added_; }
  /// Whether it is known what is taken out of this run's scans.
  [[nodiscard]] bool decided() const { return decided_; }
  /// Takes a scan whose pose is final, motion taken out, corrected by `taken_out()` as it was when the scan came.
  void add(const Cloud& scan, const Pose& T_odom_lidar);

  /// What is taken out of the scans that come. Never null.
  [[nodiscard]] const std::shared_ptr<const RingCalibration>& taken_out() const { return taken_out_; }
  /// What is known now. Never null.
  [[nodiscard]] std::shared_ptr<const RingCalibration> calibration() const { return calibration_; }

 private:
  using Vector3 = Eigen::Vector3d;
  struct Voxel {
    int count = 0;
    Vector3 sum = Vector3::Zero();  // relative to the voxel's centre
    Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
    Vector3 centre = Vector3::Zero();
    Vector3 mean = Vector3::Zero();  // of a flat one
    Vector3 normal = Vector3::Zero();
    double gate = 0;              // points farther from it are another surface's [m]
    int inside = 0, outside = 0;  // points within the gate and not, since it was fitted
    int plane = -1;
  };
  struct Plane {
    Vector3 centre, normal, first, second;        // two axes on it
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();  // of its offset and tilts,
    Vector3 b = Vector3::Zero();
    Eigen::MatrixXd cross;     // and with the beams' parameters
    std::vector<int> crossed;  // planes that may cross it
  };
  // Sums of one scan's points on one plane, by ring.
  struct RingSums {
    Eigen::Matrix3d jj = Eigen::Matrix3d::Zero();  // range, elevation, vertical share
    Eigen::Matrix3d js = Eigen::Matrix3d::Zero();  // and the plane's offset and tilts
    Vector3 jy = Vector3::Zero();
    int count = 0;
  };
  struct ScanSums {
    std::vector<RingSums> rings;
    Eigen::Matrix3d ss = Eigen::Matrix3d::Zero();
    Vector3 sy = Vector3::Zero();
    int count = 0;
  };

  void learn_beams(const Cloud& raw);
  void switch_off();
  void insert(const Vector3& p, const Vector3& sensor);
  void flatten(Voxel& voxel, const Vector3& sensor);
  [[nodiscard]] int plane_for(const Vector3& mean, const Vector3& normal);
  template <class Visit>
  void visit_planes(const Vector3& p, int cells, Visit visit) const;
  void measure(const Cloud& scan, const Pose& T_odom_lidar);
  [[nodiscard]] bool same_place(const Pose& pose);
  [[nodiscard]] bool near_edge(const Vector3& p, int own) const;
  void take_sums(int plane, const ScanSums& sums);
  void solve();
  void decide(bool errs);
  void begin_to_take_out();
  void settle_vertical(double share, double sigma);
  void settle_vertical_as(double share);
  [[nodiscard]] Eigen::Index unknowns() const { return 2 * rings_ + 1; }

  CalibrationParams params_;
  int rings_ = 0;
  int shown_ = 0;
  std::vector<bool> counts_;  // rings that have points
  std::shared_ptr<const RingCalibration> calibration_ = std::make_shared<const RingCalibration>();
  std::shared_ptr<const RingCalibration> taken_out_ = calibration_;
  std::shared_ptr<const RingCalibration> next_;   // to be taken out from the next scan on; null: as before
  std::shared_ptr<const RingCalibration> added_;  // see added()
  bool decided_ = true;
  VoxelIndex index_;
  std::vector<Voxel> voxels_;
  std::vector<Plane> planes_;
  std::map<std::array<int, 3>, std::vector<int>> planes_at_;  // by cell of the planes' size, with their centres in it
  Eigen::MatrixXd h_;
  Eigen::VectorXd b_;
  Eigen::VectorXd prior_mean_, prior_weight_;
  Eigen::VectorXd applied_;  // parameters taken out of the points that come
  std::optional<Pose> last_;
  int at_place_ = 0;  // scans taken there
  int scans_ = 0;     // taken in all
  int since_solved_ = 0;
  int vertical_votes_ = 0;              // solutions in a row that say the same of the vertical offsets
  bool vertical_contradicted_ = false;  // the data has said neither: its errors are larger than it is told, and it settles nothing in this run
  bool vertical_settled_ = false;
  double vertical_share_ = 0, vertical_sigma_ = 0;
};

}  // namespace sgraph
