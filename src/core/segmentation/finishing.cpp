#include "finishing.hpp"

#include <cmath>
#include <limits>

#include "levels.hpp"
#include "sgraph_slam/core/segmentation/plane_fit.hpp"

namespace sgraph {
namespace {

constexpr double parallel = 0.9;  // cosine above which two planes don't meet in an edge

Eigen::AlignedBox2f box_of(const PointSet& points, const FlatSurface& surface, const PlaneAxes& axes) {
  Eigen::AlignedBox2f box;
  for (const std::uint32_t i : surface.members) box.extend(axes(points.position(i)));
  return box;
}

// Whether the part lies on the common plane: its squared distances grow by less than a third of the noise, beyond what its own fit leaves to chance
// (chi-square of three, 99.3 %).
bool fits(const FlatSurface& part, const Plane& common, double noise) {
  const auto n = static_cast<double>(part.members.size());
  const double variance = part.sigma * part.sigma;
  return mean_squared_distance(part.scatter, common) - variance <= 0.1 * noise * noise + 12.0 * variance / n;
}

bool joinable(const PointSet& points, const FlatSurface& a, const FlatSurface& b, const Limits& limits, Plane& common) {
  if (a.plane.normal.dot(b.plane.normal) < parallel) return false;
  const PlaneFit fit = fit_plane(a.scatter + b.scatter);
  if (!fit.valid) return false;
  common = fit.plane;
  if (common.normal.dot(a.plane.normal) < 0) common = {-common.normal, -common.d};
  if (!fits(a, common, limits.noise) || !fits(b, common, limits.noise)) return false;
  const PlaneAxes axes(a.plane.normal.cast<float>());
  return gap_between(box_of(points, a, axes), box_of(points, b, axes)) <= static_cast<float>(limits.params.merge_gap);
}

void join(FlatSurface& a, FlatSurface& b, const Plane& common) {
  a.plane = common;
  a.scatter += b.scatter;
  a.sigma = std::sqrt(mean_squared_distance(a.scatter, common));
  std::vector<std::uint32_t> members(a.members.size() + b.members.size());
  std::merge(a.members.begin(), a.members.end(), b.members.begin(), b.members.end(), members.begin());
  a.members = std::move(members);
  std::move(b.masks.begin(), b.masks.end(), std::back_inserter(a.masks));
}

struct Claims {
  std::vector<int> owner;       // the nearest surface, or -1
  std::vector<float> distance;  // to it, over its limit there
  std::vector<char> contested;  // it lies in another surface too
};

Claims claims_of(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const std::vector<FlatSurface>& surfaces,
                 const Limits& limits) {
  Claims claims{std::vector<int>(points.size(), -1), std::vector<float>(points.size(), std::numeric_limits<float>::infinity()),
                std::vector<char>(points.size(), 0)};
  std::vector<std::uint32_t> near;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    const FlatSurface& surface = surfaces[s];
    const PlaneF plane(surface.plane);
    const Facing facing(plane, viewpoints);
    const Limits::Distance limit = limits.distance(surface.noise);
    collect_on(points, plane, facing, limits, surface.noise, 1.0F, near);
    for (const std::uint32_t i : near) {
      if (!surface.covers(points.position(i))) continue;
      const float distance = std::abs(points.distance(plane, i)) / limit(facing.cosine(points, i));
      if (claims.owner[i] >= 0) {
        const FlatSurface& other = surfaces[static_cast<std::size_t>(claims.owner[i])];
        if (std::abs(surface.plane.normal.dot(other.plane.normal)) < parallel) claims.contested[i] = 1;
      }
      if (distance < claims.distance[i]) {
        claims.owner[i] = static_cast<int>(s);
        claims.distance[i] = distance;
      }
    }
  }
  return claims;
}

}  // namespace

std::vector<FlatSurface> merge_coplanar(const PointSet& points, std::vector<FlatSurface> surfaces, const Limits& limits) {
  bool changed = true;
  while (changed) {
    changed = false;
    for (std::size_t a = 0; a < surfaces.size(); ++a) {
      for (std::size_t b = a + 1; b < surfaces.size();) {
        Plane common;
        if (!joinable(points, surfaces[a], surfaces[b], limits, common)) {
          ++b;
          continue;
        }
        join(surfaces[a], surfaces[b], common);
        surfaces.erase(surfaces.begin() + static_cast<std::ptrdiff_t>(b));
        changed = true;
      }
    }
  }
  return surfaces;
}

std::vector<FlatSurface> reassign(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, std::vector<FlatSurface> surfaces,
                                  const Limits& limits, std::vector<int>& labels) {
  const Claims claims = claims_of(points, viewpoints, surfaces, limits);
  for (FlatSurface& surface : surfaces) surface.members.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (claims.owner[i] >= 0 && !claims.contested[i])
      surfaces[static_cast<std::size_t>(claims.owner[i])].members.push_back(static_cast<std::uint32_t>(i));
  }
  std::vector<FlatSurface> kept;
  std::vector<int> number(surfaces.size(), -1);
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    if (!fit_trimmed(points, viewpoints, limits, surfaces[s])) continue;
    drop_other_levels(points, viewpoints, limits, surfaces[s]);
    if (!large_enough(points, surfaces[s], limits)) continue;
    number[s] = static_cast<int>(kept.size());
    kept.push_back(std::move(surfaces[s]));
  }
  labels.assign(points.size(), -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (claims.owner[i] >= 0) labels[i] = number[static_cast<std::size_t>(claims.owner[i])];
  }
  return kept;
}

}  // namespace sgraph
