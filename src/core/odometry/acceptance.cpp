#include "sgraph_slam/core/odometry/acceptance.hpp"

#include <algorithm>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/odometry/relocaliser.hpp"

namespace sgraph {
namespace {

constexpr double far_rotation = 0.1;      // [rad], and
constexpr double far_translation = 0.15;  // [m]: corrections of the prediction that ask for better support:
constexpr double far_share = 0.3;         // of the usual share of matches
constexpr double least_agreement = 0.6;   // of the points that come near a surface, on it: a scan of another place has them at any distance
constexpr double new_share = 0.2;         // of the newest scan in the usual share
constexpr int longest_lost = 5;           // scans without registration over which the motion is believed to go on
constexpr int longest_mistrust = 20;      // scans after which even what the map doesn't explain goes into it

}  // namespace

AcceptanceVerdict Acceptance::accept_or_reject(const WindowResult& solved, const RigidAlignmentResult& alignment, const Knot& end, double last_end,
                                               const Eigen::Vector3d& up) {
  // A scan that ended far from its prediction must be supported better than one that is where it was expected (a doorway shows little that is known).
  const bool far = alignment.rotation > far_rotation || alignment.translation > far_translation;
  const double needed = std::max(min_inliers_, far ? far_share * usual_share_ : 0.0);
  if (solved.inlier_share >= needed && solved.agreement >= least_agreement && plausible(robot_, last_known(end.time, up), alignment, end.pose)) {
    before_ = known_;
    known_ = end;
    rejected_ = 0;
    usual_share_ += (usual_share_ > 0 ? new_share : 1.0) * (solved.inlier_share - usual_share_);
    return {};
  }
  // A short blindness is bridged by the prediction; a longer one, or one after a gap, must not run away.
  AcceptanceVerdict verdict;
  verdict.accepted = false;
  verdict.stand_still = rejected_ >= longest_lost || end.time - last_end > long_gap;
  ++rejected_;
  verdict.enters_map = rejected_ > longest_mistrust;
  return verdict;
}

std::optional<Vector6> Acceptance::velocity() const {
  if (rejected_ > 0 || !before_) return std::nullopt;
  return se3_log(before_->pose.inverse() * known_.pose) / (known_.time - before_->time);
}

}  // namespace sgraph
