#include "extraction.hpp"

#include <cmath>
#include <queue>

#include "hypotheses.hpp"
#include "levels.hpp"
#include "sgraph_slam/core/segmentation/plane_fit.hpp"
#include "sgraph_slam/core/util/voxel_set.hpp"

namespace sgraph {
namespace {

constexpr double sample_leaf = 0.12;  // the search runs on points thinned to this: support then counts area, not nearness [m]
constexpr int rounds = 3;
constexpr int growth_steps = 6;
// Real sensors see walls at grazing angles less flat than white range noise would: so much more than its share of the noise a surface may have.
constexpr double most_noise = 2.0;
constexpr float same_direction = 0.99995F;  // cosine of half a degree
constexpr double default_noise = 0.02;      // where no neighbourhood is flat [m]

PointSet thinned(const PointSet& points) {
  VoxelSet taken(sample_leaf, points.size());
  PointSet sample;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (taken.insert(points.x[i], points.y[i], points.z[i]))
      sample.add(points.position(i), points.closeness[i], points.view[i], static_cast<std::uint32_t>(i));
  }
  sample.bound_blocks();
  return sample;
}

// A small piece belongs to a wall when it lies as the wall does: the strip that a plane cuts out of clutter is spread evenly between the limits
// (rms 1.4 times the noise), or lies to one side.
bool lies_on(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const Piece& piece, const FlatSurface& surface, double noise) {
  if (piece.members.size() < 8) return false;
  const PlaneF plane(surface.plane);
  const Facing facing(plane, viewpoints);
  double sum = 0, sum2 = 0;
  for (const std::uint32_t i : piece.members) {
    const double r = points.distance(plane, i) / Limits::share(facing.cosine(points, i));
    sum += r;
    sum2 += r * r;
  }
  const auto n = static_cast<double>(piece.members.size());
  return std::abs(sum / n) < 0.5 * noise && std::sqrt(sum2 / n) < 1.3 * noise;
}

class Search {
 public:
  Search(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const SegmentationParams& params)
      : points_(points),
        viewpoints_(viewpoints),
        params_(params),
        free_(points.size(), 1),
        sample_(thinned(points)),
        random_(fingerprint(points), 0),
        limits_{params} {}

  Extraction run() {
    // Support that a surface of the smallest size could have, of either measure.
    least_support_ = std::max(8.0F, 0.3F * static_cast<float>(params_.min_area / (sample_leaf * sample_leaf)));
    least_support_ = std::min(least_support_, 0.5F * static_cast<float>(params_.min_points));
    for (int round = 0; round < rounds && sample_.size() >= 8; ++round) {
      if (!search_round()) break;
    }
    return {std::move(surfaces_), limits_.noise};
  }

 private:
  struct Candidate {
    float support;
    std::size_t number;
    std::size_t generation;  // number of surfaces when the support was counted
    // Ties go to the earlier one.
    bool operator<(const Candidate& other) const { return support < other.support || (support == other.support && number > other.number); }
  };

  void set_noise(double noise) {
    limits_.noise = noise;
    threshold_ = limits_.distance(noise)(1.0F);
  }

  float support(const PlaneF& plane) const { return score(sample_, plane, threshold_, Facing(plane, viewpoints_)); }

  bool search_round() {
    const std::vector<Hypothesis> hypotheses = sample_hypotheses(sample_, viewpoints_, params_.seeds, random_);
    if (surfaces_.empty()) set_noise(estimate_noise(hypotheses, default_noise));
    refused_.clear();
    std::priority_queue<Candidate> queue;
    for (std::size_t i = 0; i < hypotheses.size(); ++i) {
      const float s = support(hypotheses[i].plane);
      if (s >= least_support_) queue.push({s, i, surfaces_.size()});
    }
    const std::size_t before = surfaces_.size();
    while (!queue.empty()) {
      Candidate best = queue.top();
      queue.pop();
      if (best.generation != surfaces_.size()) {  // points have gone since: count again
        best.support = support(hypotheses[best.number].plane);
        best.generation = surfaces_.size();
        if (best.support >= least_support_) queue.push(best);
        continue;
      }
      const Hypothesis& hypothesis = hypotheses[best.number];
      const PlaneF plane = grown(hypothesis.plane);
      if (!refused_before(plane, hypothesis.centroid) && !extract(plane)) refused_.push_back(plane);
    }
    return surfaces_.size() > before;
  }

  // Fits the plane to its inliers until they don't grow any more: from a neighbourhood to the whole wall.
  PlaneF grown(PlaneF plane) const {
    std::vector<std::uint32_t> inliers;
    float last = -1;
    for (int step = 0; step < growth_steps; ++step) {
      const Facing facing(plane, viewpoints_);
      collect(sample_, plane, threshold_, facing, inliers);
      const PlaneFit fit = fit_plane(scatter_of(sample_, inliers));
      if (!fit.valid) return plane;
      PlaneF next(fit.plane);
      if (next.normal.dot(plane.normal) < 0) {
        next.normal = -next.normal;
        next.d = -next.d;
      }
      const float now = support(next);
      if (now <= last) return plane;
      const bool settled = now < 1.01F * last;
      plane = next;
      last = now;
      if (settled) break;
    }
    return plane;
  }

  // A rough or sparse surface gives many hypotheses, which all grow to the same plane.
  bool refused_before(const PlaneF& plane, const Eigen::Vector3f& place) const {
    return std::any_of(refused_.begin(), refused_.end(), [&](const PlaneF& other) {
      return other.normal.dot(plane.normal) > same_direction && std::abs(other.distance(place) - plane.distance(place)) < 0.2F * threshold_;
    });
  }

  // Takes the surfaces on a plane out of the search; false when there are none.
  bool extract(const PlaneF& plane) {
    const Facing facing(plane, viewpoints_);
    std::vector<std::uint32_t> inliers;
    collect(points_, plane, 1.3F * threshold_, facing, inliers);
    inliers.erase(std::remove_if(inliers.begin(), inliers.end(), [this](std::uint32_t i) { return !free_[i]; }), inliers.end());
    if (inliers.size() < static_cast<std::size_t>(params_.min_points)) return false;
    const Pieces split = connected_pieces(points_, inliers, plane, params_);

    std::vector<FlatSurface> found;
    std::vector<std::vector<const Piece*>> parts;
    std::vector<const Piece*> rest;
    for (const Piece& piece : split.pieces) {
      FlatSurface surface;
      surface.plane = plane.exact();
      surface.members = piece.members;
      if (piece.members.size() >= static_cast<std::size_t>(params_.min_points) && fit_trimmed(points_, viewpoints_, limits_, surface) &&
          large_enough(points_, surface, limits_)) {
        found.push_back(std::move(surface));
        parts.push_back({&piece});
      } else {
        rest.push_back(&piece);
      }
    }
    for (const Piece* piece : rest) {
      for (std::size_t k = 0; k < found.size(); ++k) {
        if (gap_between(parts[k].front()->box, piece->box) > static_cast<float>(params_.merge_gap) ||
            !lies_on(points_, viewpoints_, *piece, found[k], limits_.noise))
          continue;
        parts[k].push_back(piece);
        break;
      }
    }
    for (std::size_t k = 0; k < found.size(); ++k) {
      found[k].masks.push_back(mask_of(split.cells, parts[k]));
      drop_other_levels(points_, viewpoints_, limits_, found[k]);
      claim(found[k]);
      surfaces_.push_back(std::move(found[k]));
    }
    return !found.empty();
  }

  // Takes the surface's points out of the search, with those that the noise put a little beyond its threshold: they would make ghosts beside it.
  void claim(const FlatSurface& surface) {
    const PlaneF plane(surface.plane);
    const Facing facing(plane, viewpoints_);
    std::vector<std::uint32_t> near;
    collect_on(points_, plane, facing, limits_, surface.noise, 1.5F, near);
    for (const std::uint32_t i : near) {
      if (surface.covers(points_.position(i))) free_[i] = 0;
    }
    std::vector<char> stays(sample_.size());
    for (std::size_t i = 0; i < sample_.size(); ++i) stays[i] = free_[sample_.index[i]];
    sample_.keep(stays);
  }

  const PointSet& points_;
  const std::vector<Eigen::Vector3f>& viewpoints_;
  const SegmentationParams& params_;
  std::vector<char> free_;
  PointSet sample_;
  RandomStream random_;
  Limits limits_;
  float threshold_ = 0;
  float least_support_ = 0;
  std::vector<PlaneF> refused_;  // of this round
  std::vector<FlatSurface> surfaces_;
};

}  // namespace

void collect_on(const PointSet& points, const PlaneF& plane, const Facing& facing, const Limits& limits, double surface_noise, float factor,
                std::vector<std::uint32_t>& inliers) {
  const Limits::Distance limit = limits.distance(surface_noise);
  collect(points, plane, factor * limit(1.0F), facing, inliers);
  const auto beyond = [&](std::uint32_t i) { return std::abs(points.distance(plane, i)) > factor * limit(facing.cosine(points, i)); };
  inliers.erase(std::remove_if(inliers.begin(), inliers.end(), beyond), inliers.end());
}

bool fit_trimmed(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const Limits& limits, FlatSurface& surface) {
  const Eigen::Vector3d side = surface.plane.normal;
  const std::vector<std::uint32_t> all = surface.members;
  for (int step = 0; step < 4; ++step) {
    surface.scatter = scatter_of(points, surface.members);
    const PlaneFit fit = fit_plane(surface.scatter);
    if (!fit.valid) return false;
    surface.plane = fit.plane;
    if (surface.plane.normal.dot(side) < 0) surface.plane = {-fit.plane.normal, -fit.plane.d};
    surface.sigma = std::sqrt(mean_squared_distance(surface.scatter, surface.plane));
    const PlaneF plane(surface.plane);
    const Facing facing(plane, viewpoints);
    double sum = 0;
    for (const std::uint32_t i : surface.members) {
      const double r = points.distance(plane, i) / Limits::share(facing.cosine(points, i));
      sum += r * r;
    }
    surface.noise = std::sqrt(sum / static_cast<double>(surface.members.size()));
    const Limits::Distance limit = limits.distance(surface.noise);
    if (step == 3) break;
    surface.members.clear();
    for (const std::uint32_t i : all) {
      if (std::abs(points.distance(plane, i)) <= limit(facing.cosine(points, i))) surface.members.push_back(i);
    }
  }
  return true;
}

bool large_enough(const PointSet& points, const FlatSurface& surface, const Limits& limits) {
  const SegmentationParams& params = limits.params;
  if (surface.members.size() < static_cast<std::size_t>(params.min_points) || surface.sigma > limits.rms()) return false;
  if (surface.noise > most_noise * limits.noise + 0.01) return false;
  const PlaneFit fit = fit_plane(surface.scatter);
  // An even rectangle of length l has the standard deviation l / sqrt(12).
  if (!fit.valid || fit.spread[2] * std::sqrt(12.0) < params.min_length || fit.spread[1] * std::sqrt(12.0) < params.min_width) return false;
  // However they are spread, points with these deviations reach out to an area of at least twice their product.
  if (2 * fit.spread[1] * fit.spread[2] >= params.min_area) return true;
  return outline_area(outline(points, surface.members, surface.plane)) >= params.min_area;
}

Extraction extract_surfaces(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const SegmentationParams& params) {
  return Search(points, viewpoints, params).run();
}

}  // namespace sgraph
