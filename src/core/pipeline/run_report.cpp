#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>

#include "sgraph_slam/core/pipeline/run_folder.hpp"
#include "sgraph_slam/core/util/resources.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

using Json = nlohmann::ordered_json;

StageFigures figures_of(Stage stage, const std::vector<ScanRecord>& records, StageTimes StageCost::*clock) {
  std::vector<double> times;
  for (const ScanRecord& record : records) {
    const auto index = static_cast<std::size_t>(stage);
    if (record.cost.wall[index] > 0) times.push_back((record.cost.*clock)[index]);
  }
  const Statistics statistics = statistics_of(times);
  return {stage, statistics.count, statistics.mean, statistics.std, statistics.median, quantile(times, 0.99), statistics.max};
}

double length_of(const Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) length += (trajectory[i].pose.translation - trajectory[i - 1].pose.translation).norm();
  return length;
}

Json to_json(const StageFigures& figures) {
  return {{"runs", figures.runs}, {"mean", figures.mean}, {"std", figures.std}, {"p50", figures.p50}, {"p99", figures.p99}, {"max", figures.max}};
}

Json to_json(const StepFigures& figures) {
  return {{"runs", figures.runs}, {"total_s", figures.total}, {"mean", figures.mean}, {"p99", figures.p99}, {"max", figures.max}};
}

Json to_json(const SolveSummary& solve) {
  return {{"keyframes", solve.keyframes},       {"planes", solve.planes},         {"factors", solve.factors}, {"iterations", solve.iterations},
          {"initial_cost", solve.initial_cost}, {"final_cost", solve.final_cost}, {"ms", solve.milliseconds}, {"converged", solve.converged}};
}

Json to_json(const Localisation& place) {
  Json json = {{"result", to_string(place.result)}, {"stamp", place.stamp.seconds()},
               {"travelled_m", place.travelled},    {"ms", place.milliseconds},
               {"hypotheses", place.hypotheses},    {"reason", place.reason},
               {"wall_m", place.fit.total},         {"matched_m", place.fit.matched},
               {"unknown_m", place.fit.unknown},    {"contradicted_m", place.fit.contradicted}};
  if (place.result == LocalisationResult::found) {
    const Eigen::Vector3d& t = place.T_map_base.translation;
    const Eigen::Quaterniond& q = place.T_map_base.rotation;
    json["pose"] = {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
  }
  return json;
}

Json to_json(const SensorDescription& sensor) {
  return {{"model", sensor.model},
          {"rings", sensor.rings},
          {"ring_source", sensor.ring_source},
          {"elevations_deg", sensor.elevations_deg},
          {"vertical_offsets", sensor.vertical_offsets},
          {"vertical_offsets_m", sensor.vertical_offsets_m},
          {"sweep", sensor.sweep},
          {"turn_s", sensor.turn},
          {"coverage_deg", sensor.coverage_deg},
          {"slices", sensor.slices},
          {"times", {{"source", sensor.time_source}, {"unit", sensor.time_unit}, {"origin", sensor.time_origin}, {"stamp", sensor.stamp}}},
          {"intensity", sensor.intensity}};
}

Json to_json(const RingCalibration& calibration) {
  constexpr double degree = M_PI / 180;
  Json beams = Json::array();
  for (const BeamCalibration& beam : calibration.beams) {
    beams.push_back({{"range_mm", 1e3 * beam.range_offset},
                     {"range_sigma_mm", 1e3 * beam.range_sigma},
                     {"range_applied", beam.range_applied},
                     {"elevation_deg", beam.elevation_offset / degree},
                     {"elevation_sigma_deg", beam.elevation_sigma / degree},
                     {"elevation_applied", beam.elevation_applied}});
  }
  return {{"scans", calibration.scans},
          {"vertical_offsets_lacking", calibration.vertical_share},
          {"vertical_offsets_sigma", calibration.vertical_sigma},
          {"vertical_offsets_settled", calibration.vertical_settled},
          {"vertical_offsets_added", calibration.vertical_applied},
          {"beams", beams}};
}

template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

std::string listed(const std::map<std::string, int>& counts) {
  std::string text;
  for (const auto& [name, count] : counts) text += (text.empty() ? "" : ", ") + name + ' ' + std::to_string(count);
  return text;
}

}  // namespace

RunReport make_report(const Run& run, const RunInfo& info) {
  RunReport report;
  report.info = info;
  const auto& records = run.records();
  report.scans = static_cast<int>(records.size());
  report.dropped = info.dropped_before;
  for (const ScanRecord& record : records) {
    if (record.verdict != ScanVerdict::accepted) {
      ++report.dropped[to_string(record.verdict)];
    } else if (run.until() >= Stage::odometry) {
      ++report.odometry_status[to_string(record.motion.status)];
      ++report.accepted;
      report.degenerate += record.motion.degenerate;
    }
  }
  const GraphSnapshotPtr snapshot = run.snapshot();
  report.keyframes = static_cast<int>(run.odometry_keyframes().size());
  report.planes = static_cast<int>(snapshot->planes.size());
  report.rooms = static_cast<int>(snapshot->rooms.size());
  report.corridors = static_cast<int>(snapshot->corridors.size());
  report.path_length = length_of(run.trajectory());
  if (!records.empty()) report.data_seconds = records.back().stamp - records.front().stamp;
  if (info.wall_seconds > 0) report.times_real_time = report.data_seconds / info.wall_seconds;
  const StageTimes cpu = run.total_cost().cpu;
  report.cpu_seconds = info.cpu_seconds.value_or(1e-3 * std::accumulate(cpu.begin(), cpu.end(), 0.0));
  report.peak_memory_mib = peak_memory_mib();
  for (const Stage stage : all_stages) {
    if (stage > run.until()) continue;
    report.stages.push_back(figures_of(stage, records, &StageCost::wall));
    report.stages_cpu.push_back(figures_of(stage, records, &StageCost::cpu));
  }
  for (const auto& [step, times] : run.steps()) {
    const Statistics statistics = statistics_of(times);
    report.mapping_steps.push_back(
        {step, statistics.count, 1e-3 * statistics.mean * statistics.count, statistics.mean, quantile(times, 0.99), statistics.max});
  }
  report.finish_milliseconds = run.finish_cost().wall;
  report.solves = run.solves();
  report.localisation = run.localisation();
  return report;
}

std::string report_json(const RunReport& report) {
  Json stages = Json::object();
  Json finish = Json::object();
  for (const StageFigures& figures : report.stages) {
    stages[to_string(figures.stage)] = to_json(figures);
    finish[to_string(figures.stage)] = report.finish_milliseconds[static_cast<std::size_t>(figures.stage)];
  }
  Json stages_cpu = Json::object();
  for (const StageFigures& figures : report.stages_cpu) stages_cpu[to_string(figures.stage)] = to_json(figures);
  Json steps = Json::object();
  for (const StepFigures& figures : report.mapping_steps) steps[figures.step] = to_json(figures);
  Json solves = Json::array();
  for (const SolveSummary& solve : report.solves) solves.push_back(to_json(solve));
  Json json = {{"sources", report.info.sources},
               {"stopped_by", report.info.stopped_by},
               {"counts",
                {{"scans", report.scans},
                 {"accepted", report.accepted},
                 {"degenerate", report.degenerate},
                 {"keyframes", report.keyframes},
                 {"planes", report.planes},
                 {"rooms", report.rooms},
                 {"corridors", report.corridors}}},
               {"dropped", report.dropped},
               {"odometry_status", report.odometry_status},
               {"path_length_m", report.path_length},
               {"data_seconds", report.data_seconds},
               {"wall_seconds", report.info.wall_seconds},
               {"times_real_time", report.times_real_time},
               {"cpu_seconds", report.cpu_seconds},
               {"peak_memory_mib", report.peak_memory_mib},
               {"stages_ms", stages},
               {"stages_cpu_ms", stages_cpu},
               {"mapping_steps_cpu_ms", steps},
               {"finish_ms", finish},
               {"solves", solves}};
  if (report.localisation) json["localisation"] = to_json(*report.localisation);
  if (report.info.store) {
    const RecordingFigures& store = *report.info.store;
    json["store"] = {{"path", store.path}, {"bytes", store.bytes}, {"cpu_seconds", store.cpu_seconds}};
  }
  if (report.info.sensor) json["sensor"] = to_json(*report.info.sensor);
  if (report.info.calibration && !report.info.calibration->beams.empty()) json["sensor"]["calibration"] = to_json(*report.info.calibration);
  if (!report.info.readings_dropped.empty()) json["readings_dropped"] = report.info.readings_dropped;
  if (!report.info.notes.empty()) json["notes"] = report.info.notes;
  return json.dump(1) + '\n';
}

std::string report_table(const RunReport& report) {
  std::ostringstream text;
  text << format("%d scans over %.1f s, %.1f m\n", report.scans, report.data_seconds, report.path_length);
  if (!report.dropped.empty()) text << "scans dropped: " << listed(report.dropped) << '\n';
  if (!report.odometry_status.empty()) text << "odometry: " << listed(report.odometry_status) << '\n';
  if (report.degenerate > 0) text << format("%d scans didn't hold every direction of motion\n", report.degenerate);
  if (!report.solves.empty()) {
    text << format("map: %d keyframes, %d planes, %d rooms, %d corridors, %zu solves\n", report.keyframes, report.planes, report.rooms,
                   report.corridors, report.solves.size());
  }
  if (report.localisation) text << "place in the map: " << to_string(report.localisation->result) << " (" << report.localisation->reason << ")\n";
  text << format("\n%-14s %6s %9s %9s %9s %9s\n", "stage [ms]", "runs", "mean", "p50", "p99", "max");
  for (const StageFigures& figures : report.stages) {
    text << format("%-14s %6d %9.2f %9.2f %9.2f %9.2f\n", to_string(figures.stage), figures.runs, figures.mean, figures.p50, figures.p99,
                   figures.max);
  }
  const double share = report.data_seconds > 0 ? report.cpu_seconds / report.data_seconds : 0;
  text << format("\n%.1f x real time (%.1f s), CPU %.1f s (%.2f s a second of data), peak memory %.0f MiB\n", report.times_real_time,
                 report.info.wall_seconds, report.cpu_seconds, share, report.peak_memory_mib);
  return text.str();
}

std::string timings_csv(const std::vector<ScanRecord>& records) {
  std::ostringstream text;
  text << "stamp";
  for (const Stage stage : all_stages) text << ',' << to_string(stage) << "_ms";
  text << ",points,kept,verdict,status,inlier_share,residual_rms_m,iterations,keyframes,segments\n";
  for (const ScanRecord& record : records) {
    const std::int64_t ns = record.stamp.nanoseconds;
    text << format("%lld.%09lld", static_cast<long long>(ns / 1'000'000'000), static_cast<long long>(ns % 1'000'000'000));
    for (const double ms : record.cost.wall) text << format(",%.3f", ms);
    const MotionQuality& motion = record.motion;
    text << format(",%d,%d,%s,%s,%.3f,%.4f,%d,%d,%d\n", record.counts.input, record.counts.kept, to_string(record.verdict), to_string(motion.status),
                   motion.inlier_share, motion.residual_rms, motion.iterations, record.keyframes, record.segments);
  }
  return text.str();
}

}  // namespace sgraph
