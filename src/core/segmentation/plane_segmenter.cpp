#include "sgraph_slam/core/segmentation/plane_segmenter.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "extraction.hpp"
#include "finishing.hpp"
#include "point_set.hpp"
#include "segment_covariance.hpp"

namespace sgraph {
namespace {

constexpr std::size_t most_viewpoints = 256;

// At most 256 of them, evenly chosen; the origin when there are none.
std::vector<Viewpoint> usable(const std::vector<Viewpoint>& given) {
  if (given.empty()) return {Viewpoint{}};
  if (given.size() <= most_viewpoints) return given;
  std::vector<Viewpoint> chosen;
  for (std::size_t k = 0; k < most_viewpoints; ++k) chosen.push_back(given[k * given.size() / most_viewpoints]);
  return chosen;
}

PlaneSegment segment_of(const PointSet& points, const FlatSurface& surface) {
  PlaneSegment segment;
  segment.plane = surface.plane;
  segment.scatter = surface.scatter;
  segment.sigma = surface.sigma;
  segment.count = static_cast<int>(surface.members.size());
  segment.centroid = surface.scatter.block<3, 1>(0, 3) / surface.scatter(3, 3);
  segment.extent = outline(points, surface.members, surface.plane);
  return segment;
}

}  // namespace

PlaneSegmenter::PlaneSegmenter(const SegmentationParams& params) : params_(params) {
  if (params.min_threshold > params.max_threshold)
    throw std::runtime_error("segmentation.min_threshold must not be above segmentation.max_threshold");
  if (params.gap > params.max_gap) throw std::runtime_error("segmentation.gap must not be above segmentation.max_gap");
}

PlaneSegments PlaneSegmenter::process(const Cloud& cloud, std::vector<int>* labels) const {
  PlaneSegments result;
  result.stamp = cloud.stamp;
  const std::vector<Viewpoint> viewpoints = usable(cloud.viewpoints);
  const PointSet points = point_set(cloud, viewpoints);
  std::vector<Eigen::Vector3f> positions;
  for (const Viewpoint& viewpoint : viewpoints) positions.emplace_back(viewpoint.position.cast<float>());

  Extraction extraction = extract_surfaces(points, positions, params_);
  const Limits limits{params_, extraction.noise};
  // Cleaned of each other's points first: a far strip of the floor with some of the wall's foot in it wouldn't lie on the floor.
  std::vector<int> owners;
  std::vector<FlatSurface> surfaces = reassign(points, positions, std::move(extraction.surfaces), limits, owners);
  surfaces = reassign(points, positions, merge_coplanar(points, std::move(surfaces), limits), limits, owners);

  std::vector<std::size_t> order(surfaces.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return surfaces[a].members.size() > surfaces[b].members.size(); });
  std::vector<int> rank(surfaces.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    rank[order[k]] = static_cast<int>(k);
    result.segments.push_back(segment_of(points, surfaces[order[k]]));
  }
  const double usual = usual_sigma(result.segments);
  for (std::size_t k = 0; k < order.size(); ++k)
    result.segments[k].covariance = segment_covariance(cloud, points, positions, surfaces[order[k]], usual);
  if (labels != nullptr) {
    labels->assign(cloud.size(), -1);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (owners[i] >= 0) (*labels)[points.index[i]] = rank[static_cast<std::size_t>(owners[i])];
    }
  }
  return result;
}

}  // namespace sgraph
