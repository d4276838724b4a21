#include "sgraph_slam/core/odometry/relocaliser.hpp"

#include <algorithm>

#include "sgraph_slam/core/registration/vertical.hpp"

namespace sgraph {
namespace {

constexpr double poor_share = 0.7;      // of the usual share of matches: below it other starts are tried,
constexpr double poor_after_gap = 0.9;  // and below this one after a gap
constexpr double near_kernel = 0.15;    // [m] where all that is seen is near: a wider one would take the next step of a flight for this one
constexpr double clearly_better = 1.1;  // support that another start must have

// Every second keypoint where the predicted motion puts it.
std::vector<SeenPoint> predicted_points(const StartQuery& query) {
  const std::vector<SegmentMotion> motions = segment_motions(query.knots);
  std::vector<SeenPoint> points;
  for (std::size_t i = 0; i < query.scan.keypoints.size(); i += 2) {
    const Point& point = query.scan.keypoints[i];
    const SegmentTime at = locate(query.knots, query.scan.time_of(point));
    const SegmentMotion& motion = motions[static_cast<std::size_t>(at.segment)];
    const Eigen::Vector3d sensor = motion.origin(at.fraction);
    points.push_back({motion.rotate(at.fraction, point.position().cast<double>()) + sensor, sensor});
  }
  return points;
}

}  // namespace

RigidAlignmentResult find_start(const MapUpdater& local, const Acceptance& acceptance, const StartQuery& query) {
  const WindowScan& scan = query.scan;
  const std::vector<SeenPoint> points = predicted_points(query);
  RigidAlignmentOptions options;
  options.noise = local.noise();
  options.kernel_begin = acceptance.rejected() > 0 ? 1.0 : scan.narrow ? near_kernel : 0.5;
  if (scan.in_cabin) {
    // Nothing but a few wrong matches would hold the height: points of walls on floors half a metre away.
    options.plumb_along = local.up();
    options.kernel_begin = near_kernel;
  }
  options.kernel_end = std::max(0.1, 4.0 * local.noise());
  RigidAlignmentResult best = align_rigidly(local.map(), points, options);
  const bool far_ahead = scan.end - query.last_end > long_gap;
  const bool as_usual = best.inlier_share >= (far_ahead ? poor_after_gap : poor_share) * acceptance.usual_share();
  if (as_usual && (acceptance.usual_share() > 0 || !far_ahead)) return best;
  // The prediction was far off: look around for a better start with few of the points, and align all of them from the best.
  std::vector<SeenPoint> few;
  for (std::size_t i = 0; i < points.size(); i += 4) few.push_back(points[i]);
  RigidAlignmentOptions search = options;
  search.reach = Reach::neighbours;
  search.kernel_begin = 1.5;
  search.iterations = 10;
  // Upright by the walls and floors of the scan itself.
  const SurfaceMap own = local.map_of(*deskew(*scan.cloud, scan.time, query.knots), pose_at(query.knots, scan.time));
  const Eigen::Vector3d up = local.up();
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(vertical_of(own, up).value_or(up), up);
  const LastKnown known = acceptance.last_known(scan.end, up);
  const Pose predicted = pose_at(query.knots, scan.end);
  RigidAlignmentResult found;
  for (const Pose& start : other_starts(known, predicted, pose_at(query.knots, query.last_end), upright)) {
    search.start = start;
    const RigidAlignmentResult other = align_rigidly(local.map(), few, search);
    if (plausible(acceptance.robot(), known, other, other.correction * predicted) && other.support > found.support) found = other;
  }
  options.start = found.correction;
  found = align_rigidly(local.map(), points, options);
  if (plausible(acceptance.robot(), known, found, found.correction * predicted) && found.support > clearly_better * best.support) best = found;
  return best;
}

}  // namespace sgraph
