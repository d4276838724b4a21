#include "sgraph_slam/core/eval/storey_score.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

namespace sgraph {
namespace {

using nlohmann::json;

constexpr double edge = 0.15;  // [s] about a change of storey: stretches are told by tenths of a second

std::optional<int> storey_at(const TrueStoreys& truth, double time, bool* sure) {
  for (const StoreyStretch& stretch : truth.path) {
    if (time > stretch.end) continue;
    *sure = time > stretch.begin + edge && time < stretch.end - edge;
    return stretch.storey;
  }
  *sure = false;
  return std::nullopt;
}

// The true storey that most keyframes of each found one are on.
std::map<int, int> truth_of_found(const std::map<int, std::map<int, int>>& counts) {
  std::map<int, int> result;
  std::set<int> taken;
  for (const auto& [found, truths] : counts) {
    int best = -1;
    int most = 0;
    for (const auto& [truth, count] : truths) {
      if (count > most && taken.count(truth) == 0) {
        best = truth;
        most = count;
      }
    }
    if (best >= 0) taken.insert(best);
    result[found] = best;
  }
  return result;
}

}  // namespace

std::optional<TrueStoreys> read_true_storeys(const std::string& truth_json) {
  try {
    const json truth = json::parse(truth_json);
    if (!truth.contains("storey_of_path") || !truth.contains("storeys")) return std::nullopt;
    TrueStoreys result;
    std::map<int, double> elevations;
    for (const json& storey : truth.at("storeys")) elevations[storey.at("storey").get<int>()] = storey.at("elevation").get<double>();
    for (const auto& [number, elevation] : elevations) {
      if (number != static_cast<int>(result.elevations.size())) throw std::runtime_error("storeys are not numbered from 0");
      result.elevations.push_back(elevation);
    }
    for (const json& j : truth.at("storey_of_path")) {
      StoreyStretch stretch{j.at("begin").get<double>(), j.at("end").get<double>(), std::nullopt};
      if (!j.at("storey").is_null()) stretch.storey = j.at("storey").get<int>();
      result.path.push_back(stretch);
    }
    return result;
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("truth.json: storeys: ") + error.what());
  }
}

StoreyScore score_storeys(const GraphSnapshot& graph, const TrueStoreys& truth, Stamp start, const Pose& T_truth_map) {
  StoreyScore score;
  std::set<int> visited;
  for (const StoreyStretch& stretch : truth.path) {
    if (stretch.storey) visited.insert(*stretch.storey);
  }
  score.truths = static_cast<int>(visited.size());
  std::map<int, std::map<int, int>> counts;  // found, true
  std::set<int> found;
  for (const auto& [id, keyframe] : graph.keyframes) {
    bool sure = false;
    const auto storey = storey_at(truth, keyframe.stamp - start, &sure);
    if (keyframe.storey == stairwell) continue;
    found.insert(keyframe.storey);
    if (storey) ++counts[keyframe.storey][*storey];
  }
  score.estimates = static_cast<int>(found.size());
  const std::map<int, int> names = truth_of_found(counts);
  for (const auto& [id, keyframe] : graph.keyframes) {
    bool sure = false;
    const auto storey = storey_at(truth, keyframe.stamp - start, &sure);
    if (!sure) continue;
    const auto name = names.find(keyframe.storey);
    if (storey) {
      ++score.keyframes;
      score.right += name != names.end() && name->second == *storey ? 1 : 0;
      continue;
    }
    ++score.on_stairs;
    if (keyframe.storey == stairwell) continue;
    bool near = false;
    if (name != names.end() && name->second >= 0) {
      const double base = (T_truth_map * graph.keyframes.begin()->second.T_map_base).translation.z() - truth.elevations.front();  // above its floor
      const double z = (T_truth_map * keyframe.T_map_base).translation.z() - base;
      near = std::abs(z - truth.elevations.at(static_cast<std::size_t>(name->second))) < 0.5;
    }
    score.stairs_misplaced += near ? 0 : 1;
  }
  std::map<int, double> floors;
  for (const SceneStorey& storey : graph.storeys) {
    const auto name = names.find(storey.id);
    if (name == names.end() || name->second < 0) continue;
    if (storey.height_known) {
      floors[name->second] = storey.z;
    } else {
      ++score.heights_unknown;
    }
  }
  for (const auto& [number, z] : floors) {
    if (number == floors.begin()->first) continue;
    const double wanted =
        truth.elevations.at(static_cast<std::size_t>(number)) - truth.elevations.at(static_cast<std::size_t>(floors.begin()->first));
    score.height_errors.push_back(z - floors.begin()->second - wanted);
  }
  for (const auto& [id, plane] : graph.planes) {
    if (plane.storey == stairwell) continue;  // a shaft's walls are seen from every floor's edge
    std::set<int> storeys;
    for (const KeyframeId seen : plane.keyframes) {
      const auto keyframe = graph.keyframes.find(seen);
      if (keyframe != graph.keyframes.end() && keyframe->second.storey != stairwell) storeys.insert(keyframe->second.storey);
    }
    score.planes_across += storeys.size() > 1 ? 1 : 0;
  }
  return score;
}

}  // namespace sgraph
