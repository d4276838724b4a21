#include "sgraph_slam/core/eval/true_associations.hpp"

#include <map>

#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

// Optimises a graph of the snapshot's keyframes; nothing when it can't be.
std::optional<Trajectory> optimised(const GraphSnapshot& snapshot, std::map<PlaneId, Plane> planes, std::vector<Factor> factors) {
  Transaction edit;
  edit.reason = "evaluation";
  for (const auto& [id, keyframe] : snapshot.keyframes) edit.keyframes[id] = keyframe.T_map_base;
  edit.planes = std::move(planes);
  edit.factors = std::move(factors);
  Graph graph;
  if (!graph.apply(edit).ok()) return std::nullopt;
  SolverOptions options;
  options.max_iterations = 100;
  options.function_tolerance = 1e-8;
  solve(graph, options);
  Trajectory poses;
  for (const auto& [id, keyframe] : snapshot.keyframes) poses.push_back({keyframe.stamp, *graph.find(id)});
  return poses;
}

}  // namespace

std::optional<TrueAssociations> with_true_associations(const GraphSnapshot& snapshot, const Trajectory& truth, const Pose& T_truth_map,
                                                       const std::vector<WallFace>& faces, const WallScore& walls) {
  std::vector<ScenePlane> scene;
  std::map<PlaneId, Plane> mapped_planes;
  for (const auto& [id, plane] : snapshot.planes) {
    scene.push_back(plane);
    mapped_planes[id] = plane.plane;
  }
  const FaceLines lines = face_lines(faces);
  const std::vector<AssociatedPlane> observations = associated_planes(snapshot);
  const auto found = true_lines(observations, scene, truth, T_truth_map, lines, walls);

  const std::int64_t first_new = mapped_planes.empty() ? 0 : mapped_planes.rbegin()->first.value + 1;
  std::map<PlaneId, Plane> true_planes;
  std::vector<Factor> mapped_factors;
  std::vector<Factor> true_factors;
  std::size_t observation = 0;  // in the order of associated_planes
  for (const auto& [id, factor] : factors_from_json(snapshot.factors_json)) {
    if (std::holds_alternative<Se3Between>(factor.data)) {
      mapped_factors.push_back(factor);
      true_factors.push_back(factor);
    }
    const auto* seen = std::get_if<PosePlane>(&factor.data);
    if (seen == nullptr || snapshot.keyframes.count(seen->keyframe) == 0) continue;
    mapped_factors.push_back(factor);
    Factor& corrected = true_factors.emplace_back(factor);
    if (const auto line = found[observation++]) {
      const PlaneId plane{first_new + static_cast<std::int64_t>(*line)};
      true_planes[plane] = T_truth_map.inverse() * lines.planes[*line];
      std::get<PosePlane>(corrected.data).plane = plane;
    } else {
      true_planes[seen->plane] = mapped_planes.at(seen->plane);
    }
  }
  std::optional<Trajectory> mapped = optimised(snapshot, std::move(mapped_planes), std::move(mapped_factors));
  std::optional<Trajectory> corrected = optimised(snapshot, std::move(true_planes), std::move(true_factors));
  if (!mapped || !corrected) return std::nullopt;
  return TrueAssociations{std::move(*mapped), std::move(*corrected)};
}

}  // namespace sgraph
