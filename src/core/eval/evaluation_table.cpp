#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "sgraph_slam/core/eval/evaluation.hpp"

namespace sgraph {
namespace {

constexpr double degrees = 180 / M_PI;

[[gnu::format(printf, 2, 3)]] void add_line(std::string& text, const char* format, ...) {
  char line[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  text += line;
  text += '\n';
}

void add_trajectory(std::string& text, const char* name, const TrajectoryEvaluation& e) {
  add_line(text, "%s: %d of %d poses, %.1f m, %.1f s", name, e.pairs, e.poses, e.length, e.duration);
  add_line(text, "                              rmse      mean    median       max");
  const auto row = [&text](const char* what, const Statistics& s) {
    add_line(text, "  %-22s %9.4f %9.4f %9.4f %9.4f", what, s.rmse, s.mean, s.median, s.max);
  };
  row("ATE [m]", e.absolute.translation);
  row("ATE [deg]", e.absolute.rotation_deg);
  if (e.relative.translation.count > 0) {
    row("RPE 10 m [m]", e.relative.translation);
    row("RPE 10 m [deg]", e.relative.rotation_deg);
  }
  if (e.drift.segments > 0) {
    add_line(text, "  drift over 10 m        %9.3f %%  %8.4f deg/m  (%d segments)", e.drift.translation_percent, e.drift.rotation_deg_per_m,
             e.drift.segments);
  }
  add_line(text, "  start to end           %9.4f m  %8.4f deg", e.start_to_end.translation, e.start_to_end.rotation * degrees);
}

void add_map(std::string& text, const MapError& e, double cap) {
  const double share = e.points == 0 ? 0 : 100.0 * e.structure.count / e.points;
  add_line(text, "map to plan: rmse %.4f m, median %.4f m over %d of %d points (%.1f %%)", e.structure.rmse, e.structure.median, e.structure.count,
           e.points, share);
  add_line(text, "  walls                  %9.4f m  (%d points)", e.walls.rmse, e.walls.count);
  add_line(text, "  floors and ceilings    %9.4f m  (%d points)", e.horizontal.rmse, e.horizontal.count);
  add_line(text, "  ghosts                 %9.2f %% of the points more than %.2f m off every surface; 95 %% within %.4f m", 100 * e.ghost_share,
           ghost_distance, e.p95);
  add_line(text,
           "  left out: %d further than %.2f m from every surface, %d on furniture, %d at a height the truth doesn't know, %d "
           "where it lists no furniture",
           e.beyond_cap, cap, e.furniture.count, e.unknown_height, e.unknown_inside);
}

void add_walls(std::string& text, const WallScore& s) {
  add_line(text, "walls: %zu of %d faces found (recall %.3f), %d duplicates (%.1f %%)", s.matches.size(), s.faces, s.recall(), s.duplicates,
           100 * s.duplicate_share());
  add_line(text, "  further vertical planes: %zu on a face but looking into the wall, %zu on no face", s.reversed_planes.size(),
           s.other_planes.size());
  if (s.matches.empty()) return;
  const Statistics normal = s.normal_error_deg();
  const Statistics position = s.position_error();
  add_line(text, "  normal [deg]           median %.3f  mean %.3f  max %.3f", normal.median, normal.mean, normal.max);
  add_line(text, "  position [m]           median %.4f  mean %.4f  max %.4f", position.median, position.mean, position.max);
}

void add_quality(std::string& text, const PlaceQuality& s) {
  add_line(text, "places: panoptic quality %.3f (recognition %.3f, outlines %.3f), %zu of %d found, %zu invented", s.panoptic(), s.recognition(),
           s.segmentation(), s.matches.size(), s.truths, s.invented.size());
  add_line(text, "  best overlap of the true ones %.1f %%, of the found ones %.1f %%", 100 * s.iou_of_truths, 100 * s.iou_of_found);
  for (const std::string& missed : s.missed) add_line(text, "  %-8s missed", missed.c_str());
  for (const long long id : s.invented) add_line(text, "  %lld is no true one", id);
}

void add_doors(std::string& text, const DoorQuality& s) {
  const Statistics position = statistics_of(s.position_errors);
  const Statistics width = statistics_of(s.width_errors);
  add_line(text, "doors: %zu of %d found (recall %.2f), %zu of %d finds right (precision %.2f); position %.3f m, width %.3f m (rms)",
           s.position_errors.size(), s.truths, s.recall(), s.position_errors.size(), s.estimates, s.precision(), position.rmse, width.rmse);
  for (const std::string& missed : s.missed) add_line(text, "  %-8s missed", missed.c_str());
  for (const long long id : s.invented) add_line(text, "  find %lld is no true one", id);
}

void add_storeys(std::string& text, const StoreyScore& s) {
  add_line(text, "storeys: %d found of %d; %d of %d keyframes on theirs, %d of %d on stairs misplaced; %d planes taken for one across storeys",
           s.estimates, s.truths, s.right, s.keyframes, s.stairs_misplaced, s.on_stairs, s.planes_across);
  for (const double error : s.height_errors) add_line(text, "  height against the first %+.4f m", error);
  if (s.heights_unknown > 0) add_line(text, "  height of %d unknown", s.heights_unknown);
}

void add_places(std::string& text, const char* name, const PlaceScore& s) {
  add_line(text, "%s: %zu of %d found (recall %.2f), %zu of %d finds right (precision %.2f), %d found twice", name, s.matches.size(), s.truths,
           s.recall(), s.matches.size(), s.estimates, s.precision(), s.duplicates);
  for (const PlaceMatch& m : s.matches) {
    add_line(text, "  %-8s found as %-4lld   centre %.4f m  width %.4f m  yaw %.3f deg  overlap %.2f", m.truth.c_str(),
             static_cast<long long>(m.estimate), m.center_error, m.width_error, m.yaw_error * degrees, m.overlap);
  }
  for (const std::string& missed : s.missed) add_line(text, "  %-8s missed", missed.c_str());
  for (const std::int64_t id : s.false_alarms) add_line(text, "  find %lld is no true one", static_cast<long long>(id));
}

}  // namespace

std::string to_table(const Evaluation& e) {
  std::string text;
  if (e.final_poses) add_trajectory(text, "final poses", *e.final_poses);
  if (e.live_poses) add_trajectory(text, "live poses", *e.live_poses);
  if (e.map) add_map(text, *e.map, e.map_cap);
  if (e.walls) add_walls(text, *e.walls);
  if (e.associations && e.associations->observations > 0) {
    add_line(text, "  associations           %.2f %% of %d right; %d of another face, %d to a duplicate", 100 * e.associations->right_share(),
             e.associations->observations, e.associations->wrong_face, e.associations->split);
  }
  if (e.association_loss) {
    add_line(text, "  keyframes' ATE         %.4f m; %.4f m with the truth's associations of walls", e.association_loss->mapped,
             e.association_loss->corrected);
  }
  if (e.rooms) add_places(text, "rooms", *e.rooms);
  if (e.corridors) add_places(text, "corridors", *e.corridors);
  if (e.places) add_quality(text, *e.places);
  if (e.doors) add_doors(text, *e.doors);
  if (e.storeys) add_storeys(text, *e.storeys);
  for (const std::string& remark : e.remarks) text += "note: " + remark + "\n";
  return text;
}

}  // namespace sgraph
