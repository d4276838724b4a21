#include "sgraph_slam/core/store/map_recorder.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/io/graph_json.hpp"

namespace sgraph {
namespace {

constexpr std::int64_t scene_interval = 5;  // keyframes between two writings of the places: they can be found again from the rest

bool same(const Pose& a, const Pose& b) { return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs(); }

bool same(const Plane& a, const Plane& b) { return a.normal == b.normal && a.d == b.d; }

bool same(const StoredPlane& stored, const Plane& plane, const PlaneRecord& record, const Eigen::Matrix3d& covariance) {
  return same(stored.plane, plane) && stored.plane_class == record.plane_class && stored.covariance == covariance &&
         stored.view_covariance == record.last_covariance && stored.extent == record.outline;
}

bool same(const MergeRecord& a, const MergeRecord& b) {
  return a.kept == b.kept && same(a.plane, b.plane) && a.repointed == b.repointed && a.dropped.size() == b.dropped.size();
}

// Ids of what is known but no more.
template <class Id, class Value, class Other>
std::vector<Id> gone(std::map<Id, Value>& known, const std::map<Id, Other>& now) {
  std::vector<Id> ids;
  for (auto it = known.begin(); it != known.end();) {
    if (now.count(it->first) > 0) {
      ++it;
      continue;
    }
    ids.push_back(it->first);
    it = known.erase(it);
  }
  return ids;
}

// All of the scene but what has tables of its own.
std::string scene_text(const GraphSnapshot& snapshot) {
  GraphSnapshot scene = snapshot;
  scene.keyframes.clear();
  scene.planes.clear();
  scene.factors_json = "[]";
  scene.decisions.clear();
  return graph_json(scene);
}

// Who isn't on the first storey; empty for a map that has one.
std::string storeys_text(const GraphSnapshot& snapshot) {
  const auto others = [](const auto& map) {
    nlohmann::json pairs = nlohmann::json::array();
    for (const auto& [id, value] : map) {
      if (value.storey != 0) pairs.push_back({id.value, value.storey});
    }
    return pairs;
  };
  const nlohmann::json storeys = {{"keyframes", others(snapshot.keyframes)}, {"planes", others(snapshot.planes)}};
  return storeys["keyframes"].empty() && storeys["planes"].empty() ? std::string() : storeys.dump();
}

}  // namespace

MapRecorder::MapRecorder(MapStore& store, const StoredMap& known)
    : store_(store), poses_(known.poses), planes_(known.planes), factors_(known.factors), merges_(known.merges), retired_(known.retired) {
  for (const auto& [id, view] : known.views) viewed_.insert(id.value);
}

void MapRecorder::changed(const MapView& view) {
  StoreBatch batch;
  // One that the graph refused is not in it, or another of its id is.
  if (view.keyframe != nullptr && view.graph.find(view.keyframe->id) != nullptr && poses_.count(view.keyframe->id) == 0) {
    batch.keyframes.push_back(*view.keyframe);
  }
  batch.clouds_let_go = view.clouds_let_go;
  note_poses(view, batch);
  note_planes(view, batch);
  note_factors(view, batch);
  note_documents(view, view.keyframe == nullptr || view.keyframe->id.value % scene_interval == 0, batch);
  for (; decisions_ < view.log.size(); ++decisions_) batch.decisions.push_back(view.log[decisions_]);
  store_.write(std::move(batch));
}

void MapRecorder::note_poses(const MapView& view, StoreBatch& batch) {
  for (const auto& [id, pose] : view.graph.keyframes()) {
    const auto [known, is_new] = poses_.try_emplace(id, pose);
    if (!is_new && same(known->second, pose)) continue;
    known->second = pose;
    batch.poses.emplace_back(id, pose);
  }
}

void MapRecorder::note_planes(const MapView& view, StoreBatch& batch) {
  const bool edited = view.graph.factors_edited() != factors_edited_;  // else views have only been added, after those known
  for (const auto& [id, record] : view.planes.records()) {
    const Plane* plane = view.graph.find(id);
    if (plane == nullptr) continue;
    const auto scene = view.snapshot.planes.find(id);
    const Eigen::Matrix3d covariance = scene != view.snapshot.planes.end() ? scene->second.covariance : record.last_covariance;
    const auto [known, is_new] = planes_.try_emplace(id);
    if (is_new || !same(known->second, *plane, record, covariance)) {
      known->second = {id, *plane, record.plane_class, covariance, record.last_covariance, record.outline};
      batch.planes.push_back(known->second);
    }
    note_sightings(record, batch);
    std::size_t& written = views_[id];
    const std::size_t size = record.observations.size();
    if (written == size && !edited) continue;  // an edit may take away as many as have come
    for (std::size_t i = edited ? 0 : std::min(written, size); i < size; ++i) {
      const PlaneObservation& seen = record.observations[i];
      if (viewed_.insert(seen.factor.value).second) batch.views.push_back({seen.factor, seen.keyframe, seen.outline_base});
    }
    written = size;
  }
  batch.removed_planes = gone(planes_, view.graph.planes());
  for (const PlaneId id : batch.removed_planes) views_.erase(id);
}

// Rows of a plane stay when it is merged into another: that may be undone.
void MapRecorder::note_sightings(const PlaneRecord& record, StoreBatch& batch) {
  if (record.retired.empty()) return;
  KeyframeSet& written = retired_[record.id];
  if (written == record.retired) return;
  for (const KeyframeId keyframe : record.retired) {
    if (written.count(keyframe) == 0) batch.sightings.push_back({record.id, keyframe});
  }
  written = record.retired;
}

void MapRecorder::note_factors(const MapView& view, StoreBatch& batch) {
  // Mostly factors have only been added since the last time, those beyond the ones known, and few of the others have been edited.
  const std::map<FactorId, Factor>& now = view.graph.factors();
  const std::optional<std::set<FactorId>> edited = view.graph.factors_edited_since(factors_edited_);
  factors_edited_ = view.graph.factors_edited();
  if (!edited) {
    compare_factors(now, batch);
  } else {
    const FactorId last = factors_.empty() ? FactorId{} : factors_.rbegin()->first;
    for (const FactorId id : *edited) {
      if (!factors_.empty() && last < id) break;  // it is new
      const auto factor = now.find(id);
      const auto known = factors_.find(id);
      if (factor == now.end()) {
        if (known == factors_.end()) continue;
        batch.removed_factors.push_back(id);
        factors_.erase(known);
      } else if (known == factors_.end() || !(known->second == factor->second)) {
        batch.factors[id] = factors_[id] = factor->second;
      }
    }
    for (auto it = last.valid() ? now.upper_bound(last) : now.begin(); it != now.end(); ++it) {
      factors_.emplace_hint(factors_.end(), it->first, it->second);
      batch.factors[it->first] = it->second;
    }
  }
  for (const FactorId id : batch.removed_factors) viewed_.erase(id.value);
  for (const auto& [id, record] : view.graph.merges()) {
    const auto [known, is_new] = merges_.try_emplace(id, record);
    if (!is_new && same(known->second, record)) continue;
    known->second = record;
    batch.merges[id] = record;
  }
  batch.removed_merges = gone(merges_, view.graph.merges());
}

// All of them, with what is known. Both are in order: what is known goes along with what there is.
void MapRecorder::compare_factors(const std::map<FactorId, Factor>& now, StoreBatch& batch) {
  auto kept = factors_.begin();
  for (const auto& [id, factor] : now) {
    while (kept != factors_.end() && kept->first < id) {
      batch.removed_factors.push_back(kept->first);
      kept = factors_.erase(kept);
    }
    if (kept == factors_.end() || id < kept->first) {
      factors_.emplace_hint(kept, id, factor);
      batch.factors[id] = factor;
      continue;
    }
    if (!(kept->second == factor)) batch.factors[id] = kept->second = factor;
    ++kept;
  }
  for (; kept != factors_.end(); kept = factors_.erase(kept)) batch.removed_factors.push_back(kept->first);
}

void MapRecorder::note_documents(const MapView& view, bool whole, StoreBatch& batch) {
  const auto put = [&](const std::string& name, std::string text) {
    std::string& known = documents_[name];
    if (known == text) return;
    known = text;
    batch.documents[name] = std::move(text);
  };
  put("next_ids", nlohmann::json(next_ids(view.graph)).dump());
  if (whole) put("scene", scene_text(view.snapshot));
  const std::string storeys = whole ? storeys_text(view.snapshot) : std::string();
  if (!storeys.empty()) put("storeys", storeys);
}

}  // namespace sgraph
