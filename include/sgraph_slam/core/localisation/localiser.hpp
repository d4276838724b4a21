#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/localisation/reference_map.hpp"

namespace sgraph {

enum class LocalisationResult {
  found,
  ambiguous,  ///< several places of the map look like this
  not_found,  ///< no place of the map does, or too little has been seen yet
};

const char* to_string(LocalisationResult value);

/// What is known of the robot's place in a map.
struct Localisation {
  LocalisationResult result = LocalisationResult::not_found;
  Stamp stamp;              ///< of the keyframe with which it was known
  double travelled = 0;     ///< since the search began [m]
  double milliseconds = 0;  ///< CPU time of the longest single search
  int hypotheses = 0;       ///< places that stand up to what was seen
  Pose T_map_base;          ///< at the stamp, when found
  Pose T_map_odom;          ///< when found
  LayoutFit fit;            ///< of the best place
  LayoutFit second;         ///< of the next; empty when there is none
  std::string reason;       ///< in words
};

/// Finds out where a robot is in a map, from what it sees on its way; says so only when one place agrees with all that was seen, and no other does.
class Localiser {
 public:
  /// `near`: T_map_base of the first keyframe to within some metres and half a right angle, when somebody told; other places are not considered then.
  Localiser(std::shared_ptr<const ReferenceMap> map, const Pose& T_base_lidar, const std::optional<Pose>& near = std::nullopt)
      : map_(std::move(map)), T_base_lidar_(T_base_lidar), near_(near) {}

  /// Takes the next keyframe, in order; returns what is known now. After `found` there is no need to go on.
  const Localisation& add(LocatedKeyframe keyframe);

  [[nodiscard]] const Localisation& answer() const { return answer_; }

 private:
  void keep_near(PlaceSearchResult& places, const Surroundings& surroundings) const;
  void judge(PlaceSearchResult places, const Surroundings& surroundings);

  std::shared_ptr<const ReferenceMap> map_;
  Pose T_base_lidar_;
  std::optional<Pose> near_;
  Pose T_odom_first_;  // of the first keyframe
  std::deque<LocatedKeyframe> keyframes_;
  std::deque<double> path_;   // at each of them
  double searched_at_ = -1;   // path at the last search
  std::optional<Pose> last_;  // T_map_odom that the last search found alone
  int agreeing_ = 0;          // searches in a row that found it
  Localisation answer_;
};

}  // namespace sgraph
