#include <cmath>
#include <nlohmann/json.hpp>

#include "sgraph_slam/core/eval/evaluation.hpp"

namespace sgraph {
namespace {

using json = nlohmann::ordered_json;

constexpr double degrees = 180 / M_PI;

json json_of(const Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.std},
          {"min", s.min},   {"max", s.max},   {"sse", s.sse},       {"count", s.count}};
}

json json_of(const Pose& p) {
  const Eigen::Vector3d& t = p.translation;
  const Eigen::Quaterniond& q = p.rotation;
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

json json_of(const TrajectoryEvaluation& e) {
  return {
      {"poses", e.poses},
      {"pairs", e.pairs},
      {"length_m", e.length},
      {"duration_s", e.duration},
      {"T_truth_estimate", json_of(e.T_truth_estimate)},
      {"ate_translation_m", json_of(e.absolute.translation)},
      {"ate_rotation_deg", json_of(e.absolute.rotation_deg)},
      {"rpe_10m_translation_m", json_of(e.relative.translation)},
      {"rpe_10m_rotation_deg", json_of(e.relative.rotation_deg)},
      {"drift_10m",
       {{"segments", e.drift.segments}, {"translation_percent", e.drift.translation_percent}, {"rotation_deg_per_m", e.drift.rotation_deg_per_m}}},
      {"start_to_end", {{"translation_m", e.start_to_end.translation}, {"rotation_deg", e.start_to_end.rotation * degrees}}}};
}

json json_of(const MapError& e) {
  return {{"rmse_m", e.structure.rmse},
          {"structure_m", json_of(e.structure)},
          {"walls_m", json_of(e.walls)},
          {"horizontal_m", json_of(e.horizontal)},
          {"furniture_m", json_of(e.furniture)},
          {"points", e.points},
          {"ghost_share", e.ghost_share},
          {"p95_m", e.p95},
          {"left_out",
           {{"beyond_cap", e.beyond_cap},
            {"unknown_height", e.unknown_height},
            {"unknown_inside", e.unknown_inside},
            {"outdoors", e.outdoors},
            {"furniture", e.furniture.count}}}};
}

json json_of(const PlaceScore& s) {
  json matches = json::array();
  for (const PlaceMatch& m : s.matches) {
    matches.push_back({{"truth", m.truth},
                       {"estimate", m.estimate},
                       {"overlap", m.overlap},
                       {"center_error_m", m.center_error},
                       {"width_error_m", m.width_error},
                       {"yaw_error_deg", m.yaw_error * degrees}});
  }
  return {{"true", s.truths},
          {"found", s.estimates},
          {"precision", s.precision()},
          {"recall", s.recall()},
          {"duplicates", s.duplicates},
          {"center_error_m", json_of(s.center_error())},
          {"width_error_m", json_of(s.width_error())},
          {"matches", matches},
          {"missed", s.missed},
          {"false_alarms", s.false_alarms}};
}

json json_of(const StoreyScore& s) {
  return {{"true", s.truths},
          {"found", s.estimates},
          {"keyframes", s.keyframes},
          {"keyframes_right", s.right},
          {"keyframes_on_stairs", s.on_stairs},
          {"keyframes_on_stairs_misplaced", s.stairs_misplaced},
          {"height_errors_m", s.height_errors},
          {"heights_unknown", s.heights_unknown},
          {"planes_across_storeys", s.planes_across}};
}

json json_of(const PlaceQuality& s) {
  json matches = json::array();
  for (const QualityMatch& m : s.matches) matches.push_back({{"truth", m.truth}, {"estimate", m.estimate}, {"iou", m.iou}});
  return {{"true", s.truths},
          {"found", s.estimates},
          {"panoptic_quality", s.panoptic()},
          {"segmentation_quality", s.segmentation()},
          {"recognition_quality", s.recognition()},
          {"iou_of_true", s.iou_of_truths},
          {"iou_of_found", s.iou_of_found},
          {"matches", matches},
          {"missed", s.missed},
          {"invented", s.invented}};
}

json json_of(const DoorQuality& s) {
  return {{"true", s.truths},
          {"found", s.estimates},
          {"precision", s.precision()},
          {"recall", s.recall()},
          {"position_error_m", json_of(statistics_of(s.position_errors))},
          {"width_error_m", json_of(statistics_of(s.width_errors))},
          {"height_error_m", json_of(statistics_of(s.height_errors))},
          {"missed", s.missed},
          {"invented", s.invented}};
}

json json_of(const WallFace& face) {
  return {{"wall", face.wall},
          {"begin", {face.begin.x(), face.begin.y()}},
          {"end", {face.end.x(), face.end.y()}},
          {"normal", {face.normal.x(), face.normal.y()}},
          {"seen_m", face.seen_length}};
}

json json_of(const WallScore& s, const std::vector<WallFace>& faces) {
  json missed = json::array();
  for (const std::size_t f : s.missed) missed.push_back(json_of(faces[f]));
  json matches = json::array();
  for (const WallMatch& m : s.matches) {
    json one = json_of(faces[m.face]);
    one["plane"] = m.plane;
    one["more_planes"] = m.more;
    one["normal_error_deg"] = m.normal_error * degrees;
    one["position_error_m"] = m.position_error;
    matches.push_back(std::move(one));
  }
  return {{"faces", s.faces},
          {"found", s.matches.size()},
          {"recall", s.recall()},
          {"duplicates", s.duplicates},
          {"duplicate_share", s.duplicate_share()},
          {"normal_error_deg", json_of(s.normal_error_deg())},
          {"position_error_m", json_of(s.position_error())},
          {"reversed_planes", s.reversed_planes},
          {"other_planes", s.other_planes},
          {"missed", missed},
          {"matches", matches}};
}

json json_of(const AssociationScore& s) {
  return {{"observations", s.observations}, {"wrong_face", s.wrong_face}, {"split", s.split}, {"right_share", s.right_share()}};
}

}  // namespace

std::string to_json(const Evaluation& e) {
  json j{{"format", 1}, {"run", e.run}, {"truth", e.truth}, {"map_cap_m", e.map_cap}};
  if (e.final_poses) j["trajectory"] = json_of(*e.final_poses);
  if (e.live_poses) j["trajectory_live"] = json_of(*e.live_poses);
  if (e.map) j["map"] = json_of(*e.map);
  if (e.rooms) j["rooms"] = json_of(*e.rooms);
  if (e.corridors) j["corridors"] = json_of(*e.corridors);
  if (e.places) j["places"] = json_of(*e.places);
  if (e.doors) j["doors"] = json_of(*e.doors);
  if (e.storeys) j["storeys"] = json_of(*e.storeys);
  if (e.walls) j["walls"] = json_of(*e.walls, e.faces);
  if (e.associations) j["associations"] = json_of(*e.associations);
  if (e.association_loss) {
    j["associations"]["keyframes_ate_m"] = e.association_loss->mapped;
    j["associations"]["keyframes_ate_with_true_associations_m"] = e.association_loss->corrected;
  }
  j["remarks"] = e.remarks;
  return j.dump(1) + "\n";
}

}  // namespace sgraph
