#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {

/// A piece of floor: an outline and what is cut out of it.
struct FloorArea {
  std::vector<Eigen::Vector2d> outline;
  std::vector<std::vector<Eigen::Vector2d>> holes;
};

/// A true place (truth.json "places").
struct TruePlace {
  std::string name;
  std::string kind;  ///< room, corridor, hall, ...
  FloorArea area;
  double z = 0;         ///< floor [m]
  double height = 0;    ///< floor to ceiling [m]; 0: unknown
  bool entered = true;  ///< the path came in: it must be found; otherwise it is neither asked for nor wrong
};

/// A true passage between two places (truth.json "doors").
struct TrueDoor {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< middle of its threshold
  double width = 0;                                    ///< [m]
  double height = 0;                                   ///< [m]
  bool wanted = true;  ///< a door's width and of a place that the path entered; others are neither asked for nor wrong
};

/// What a run folder's graph.json holds of places and doors, in the map's frame.
struct MappedPlace {
  long long id = 0;
  std::string kind;  ///< room or corridor
  FloorArea area;
  double z = 0;           ///< of its middle [m]
  bool z_known = false;   ///< graphs before the key "storeys" have no height of the middle
  long long storey = -1;  ///< -1: the graph doesn't say
};
struct MappedDoor {
  long long id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double width = 0;
  double height = 0;  ///< 0: not known
};
struct MappedPlaces {
  std::vector<MappedPlace> places;
  std::vector<MappedDoor> doors;
  bool has_doors = false;  ///< the graph has the key
};
struct TruePlaces {
  std::vector<TruePlace> places;
  std::vector<TrueDoor> doors;
  bool has_doors = false;
};

/// Reads graph.json: "places", or where that isn't there "rooms" and "corridors", with "polygon" (optional "holes"), or where there is none the
/// rectangle about "center" with "width" (of a corridor also "length") and "yaw"; "doors". Throws std::runtime_error with the file.
MappedPlaces read_mapped_places(const std::string& path);

/// Reads truth.json: "places" and "doors"; without "places" the rectangles of "rooms" and "corridors". Throws std::runtime_error with the file.
TruePlaces read_true_places(const std::string& path);

/// Area that two pieces of floor have in common [m^2].
double common_area(const FloorArea& a, const FloorArea& b);
double area_of(const FloorArea& area);

/// A found place and the true one that it was matched with.
struct QualityMatch {
  std::string truth;
  long long estimate = 0;
  double iou = 0;
};

/// Places as areas: panoptic quality (Kirillov et al. 2019), where a match has an intersection over union of at least one half.
struct PlaceQuality {
  int truths = 0;     ///< true places that the path entered
  int estimates = 0;  ///< found places that count
  std::vector<QualityMatch> matches;
  std::vector<std::string> missed;
  std::vector<long long> invented;
  double iou_of_truths = 0;  ///< mean over the true places of the best intersection over union that a found one has with it
  double iou_of_found = 0;   ///< mean over the found places, with the true ones

  [[nodiscard]] double segmentation() const;  ///< mean IoU of the matches
  [[nodiscard]] double recognition() const;   ///< F1 of the matches
  [[nodiscard]] double panoptic() const { return segmentation() * recognition(); }
};

/// Doors within half a metre of each other match, the nearest first.
struct DoorQuality {
  int truths = 0;
  int estimates = 0;
  std::vector<double> position_errors;  ///< of the matches, over the floor [m]
  std::vector<double> width_errors;     ///< found minus true [m]
  std::vector<double> height_errors;    ///< likewise, where the graph says [m]
  std::vector<std::string> missed;
  std::vector<long long> invented;

  [[nodiscard]] double precision() const { return estimates == 0 ? 1 : static_cast<double>(position_errors.size()) / estimates; }
  [[nodiscard]] double recall() const { return truths == 0 ? 1 : static_cast<double>(position_errors.size()) / truths; }
};

/// `T_truth_map` aligns the map. Found places that lie mostly in true places which the path did not enter count nowhere.
PlaceQuality score_places(const std::vector<MappedPlace>& found, const std::vector<TruePlace>& truth, const Pose& T_truth_map);
DoorQuality score_doors(const std::vector<MappedDoor>& found, const std::vector<TrueDoor>& truth, const Pose& T_truth_map);

}  // namespace sgraph
