#include "sgraph_slam/core/eval/place_error.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "polygon.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

struct Found {
  std::int64_t id;
  Eigen::Vector2d center;
  Eigen::Vector2d width;  // along x, y of its own; corridors: along, across
  double yaw;
};

struct Candidate {
  double rank;  // the higher the better
  std::size_t found;
  std::size_t truth;
  PlaceMatch match;
};

// Difference of two directions that repeat after `period`, in -period/2 .. period/2.
double turn(double from, double to, double period) { return std::remainder(to - from, period); }

Found moved(std::int64_t id, const Eigen::Vector3d& center, const Eigen::Vector2d& width, double yaw, const Pose& T_truth_map) {
  const Eigen::Vector3d c = T_truth_map * center;
  const Eigen::Vector3d x = T_truth_map.rotation * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0);
  return {id, c.head<2>(), width, std::atan2(x.y(), x.x())};
}

std::vector<Candidate> room_candidate(const Found& f, const PlanPlace& t) {
  const Polygon a = rectangle(f.center, f.width, f.yaw);
  const Polygon b = rectangle(t.center, t.width, t.yaw);
  const double common = area(clip(a, b));
  const double overlap = common / (area(a) + area(b) - common);
  if (!(overlap >= 0.5)) return {};
  const double angle = turn(t.yaw, f.yaw, M_PI_2);
  const bool crossed = std::abs(turn(t.yaw, f.yaw, M_PI)) > M_PI_4;  // its x is the other's y
  const Eigen::Vector2d width = crossed ? Eigen::Vector2d(f.width.y(), f.width.x()) : f.width;
  const double width_error = (width - t.width).cwiseAbs().maxCoeff();
  return {{overlap, 0, 0, {t.name, f.id, overlap, (f.center - t.center).norm(), width_error, std::abs(angle)}}};
}

std::vector<Candidate> corridor_candidate(const Found& f, PlanPlace t) {
  if (t.width.x() < t.width.y()) t = {t.name, t.center, {t.width.y(), t.width.x()}, t.yaw + M_PI_2, t.z, t.entered};
  const double angle = std::abs(turn(t.yaw, f.yaw, M_PI));
  const double share = area(clip(rectangle(f.center, f.width, f.yaw), rectangle(t.center, t.width, t.yaw))) / (f.width.x() * f.width.y());
  const double width_error = std::abs(f.width.y() - t.width.y());
  if (!(angle < 15 * M_PI / 180) || !(share >= 0.5) || !(width_error < t.width.y() / 3)) return {};
  const Eigen::Vector2d along(std::cos(t.yaw), std::sin(t.yaw));
  const Eigen::Vector2d offset = f.center - t.center;
  const double middle = along.dot(offset);
  const double common = std::min(middle + f.width.x() / 2, t.width.x() / 2) - std::max(middle - f.width.x() / 2, -t.width.x() / 2);
  const double across = std::abs(along.x() * offset.y() - along.y() * offset.x());
  return {{common, 0, 0, {t.name, f.id, common / t.width.x(), across, width_error, angle}}};
}

using Compare = std::function<std::vector<Candidate>(const Found&, const PlanPlace&)>;

PlaceScore score(const std::vector<Found>& found, const std::vector<PlanPlace>& truth, const Compare& compare) {
  std::vector<Candidate> candidates;
  for (std::size_t f = 0; f < found.size(); ++f) {
    for (std::size_t t = 0; t < truth.size(); ++t) {
      for (Candidate& c : compare(found[f], truth[t])) candidates.push_back({c.rank, f, t, c.match});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.rank > b.rank; });

  PlaceScore result;
  result.truths = static_cast<int>(std::count_if(truth.begin(), truth.end(), [](const PlanPlace& t) { return t.entered; }));
  result.estimates = static_cast<int>(found.size());
  std::set<std::size_t> used_found;
  std::set<std::size_t> used_truth;
  for (const Candidate& c : candidates) {
    if (used_found.count(c.found) || used_truth.count(c.truth)) continue;
    used_found.insert(c.found);
    used_truth.insert(c.truth);
    if (truth[c.truth].entered) {
      result.matches.push_back(c.match);
    } else {
      --result.estimates;  // it counts nowhere
    }
  }
  for (std::size_t t = 0; t < truth.size(); ++t) {
    if (truth[t].entered && !used_truth.count(t)) result.missed.push_back(truth[t].name);
  }
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (used_found.count(f)) continue;
    result.false_alarms.push_back(found[f].id);
    const bool again = std::any_of(candidates.begin(), candidates.end(), [f](const Candidate& c) { return c.found == f; });
    result.duplicates += again ? 1 : 0;
  }
  return result;
}

Statistics of(const std::vector<PlaceMatch>& matches, double PlaceMatch::*field) {
  std::vector<double> values;
  for (const PlaceMatch& m : matches) values.push_back(m.*field);
  return statistics_of(std::move(values));
}

}  // namespace

Statistics PlaceScore::center_error() const { return of(matches, &PlaceMatch::center_error); }
Statistics PlaceScore::width_error() const { return of(matches, &PlaceMatch::width_error); }

PlaceScore score_rooms(const std::vector<SceneRoom>& found, const Pose& T_truth_map, const std::vector<PlanPlace>& truth) {
  std::vector<Found> all;
  for (const SceneRoom& r : found) {
    if (r.is_rectangle()) all.push_back(moved(r.id.value, r.center, r.width, r.yaw, T_truth_map));
  }
  return score(all, truth, room_candidate);
}

PlaceScore score_corridors(const std::vector<SceneCorridor>& found, const Pose& T_truth_map, const std::vector<PlanPlace>& truth) {
  std::vector<Found> all;
  for (const SceneCorridor& c : found) all.push_back(moved(c.id.value, c.center, {c.length, c.width}, c.yaw, T_truth_map));
  return score(all, truth, corridor_candidate);
}

}  // namespace sgraph
