#include "sgraph_slam/core/localisation/localiser.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

#include "sgraph_slam/core/search/verdict.hpp"

namespace sgraph {
namespace {

constexpr double longest_path = 12;  // of the way that is compared [m]: the odometry drifts little on it
constexpr std::size_t most_keyframes = 24;
constexpr double search_interval = 0.3;  // [m] travelled between two searches

constexpr int least_agreeing = 2;        // searches in a row that find the same place
constexpr double same_place = 0.3;       // [m]
constexpr double near_distance = 3;      // [m] of a place from where somebody said it is
constexpr double near_angle = 0.8;       // [rad]
constexpr double share_when_told = 0.4;  // of what must have been seen

double thread_milliseconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

}  // namespace

const char* to_string(LocalisationResult value) {
  switch (value) {
    case LocalisationResult::found: return "found";
    case LocalisationResult::ambiguous: return "ambiguous";
    case LocalisationResult::not_found: break;
  }
  return "not_found";
}

// Leaves the places near the one that was told; they were compared with each other only.
void Localiser::keep_near(PlaceSearchResult& places, const Surroundings& surroundings) const {
  const Pose T_level_odom{surroundings.level, Eigen::Vector3d::Zero()};
  const Pose T_level_map{map_->level(), Eigen::Vector3d::Zero()};
  const Pose first = T_level_odom * T_odom_first_;
  const Pose told = T_level_map * *near_;
  const auto yaw = [](const Pose& pose) {
    const Eigen::Matrix3d R = pose.matrix();
    return std::atan2(R(1, 0), R(0, 0));
  };
  auto& all = places.hypotheses;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const PlaceHypothesis& place) {
                             const Eigen::Vector2d at = place.T_map_query * Eigen::Vector2d(first.translation.head<2>());
                             const double turn = std::remainder(place.T_map_query.yaw + yaw(first) - yaw(told), 2 * M_PI);
                             return (at - told.translation.head<2>()).norm() > near_distance || std::abs(turn) > near_angle;
                           }),
            all.end());
  places.exhaustive = true;
}

const Localisation& Localiser::add(LocatedKeyframe keyframe) {
  const double step =
      keyframes_.empty() ? 0 : (keyframe.keyframe.T_odom_base.translation - keyframes_.back().keyframe.T_odom_base.translation).norm();
  if (keyframes_.empty()) T_odom_first_ = keyframe.keyframe.T_odom_base;
  answer_.travelled += step;
  answer_.stamp = keyframe.keyframe.stamp;
  keyframes_.push_back(std::move(keyframe));
  path_.push_back(answer_.travelled);
  while (keyframes_.size() > most_keyframes || path_.back() - path_.front() > longest_path) {
    keyframes_.pop_front();
    path_.pop_front();
  }
  if (searched_at_ >= 0 && answer_.travelled < searched_at_ + search_interval) return answer_;
  searched_at_ = answer_.travelled;
  const double begin = thread_milliseconds();
  const Surroundings surroundings = surroundings_of({keyframes_.begin(), keyframes_.end()}, T_base_lidar_);
  judge(map_->search().find(surroundings.layout), surroundings);
  answer_.milliseconds = std::max(answer_.milliseconds, thread_milliseconds() - begin);
  return answer_;
}

void Localiser::judge(PlaceSearchResult places, const Surroundings& surroundings) {
  if (near_) keep_near(places, surroundings);
  answer_.fit = places.hypotheses.empty() ? LayoutFit{} : places.hypotheses.front().fit;
  answer_.second = places.hypotheses.size() < 2 ? LayoutFit{} : places.hypotheses[1].fit;
  answer_.hypotheses = 0;
  const int agreeing = std::exchange(agreeing_, 0);
  if (places.hypotheses.empty()) {
    answer_.result = LocalisationResult::not_found;
    answer_.reason = "no place of the map looks like this";
    return;
  }
  const LayoutFit& best = answer_.fit;
  const PlaceVerdict verdict = judge_places(places, surroundings.layout, near_ ? share_when_told : 1);
  if (!verdict.stands) {
    answer_.result = LocalisationResult::not_found;
    answer_.reason = "the place that fits best contradicts what was seen: " + to_string(best);
    return;
  }
  answer_.result = LocalisationResult::ambiguous;
  answer_.hypotheses = verdict.possible - (places.exhaustive ? 0 : 1);
  if (verdict.possible > 1) {
    answer_.reason = std::to_string(answer_.hypotheses) + (places.exhaustive ? "" : " or more") + " places look alike: " + to_string(best);
    return;
  }
  if (!verdict.enough) {
    answer_.reason = "too little has been seen: " + to_string(best);
    return;
  }
  answer_.T_map_odom =
      pose_from_place(*map_, surroundings, {keyframes_.begin(), keyframes_.end()}, T_base_lidar_, places.hypotheses.front().T_map_query);
  answer_.T_map_base = answer_.T_map_odom * keyframes_.back().keyframe.T_odom_base;
  const bool agrees = last_ && (*last_ * keyframes_.back().keyframe.T_odom_base.translation - answer_.T_map_base.translation).norm() < same_place;
  agreeing_ = agrees ? agreeing + 1 : 1;
  last_ = answer_.T_map_odom;
  answer_.reason = to_string(best);
  if (agreeing_ < least_agreeing) {
    answer_.reason = "to be confirmed: " + answer_.reason;
    return;
  }
  answer_.result = LocalisationResult::found;
}

}  // namespace sgraph
