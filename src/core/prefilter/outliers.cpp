#include "outliers.hpp"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace sgraph {
namespace {

pcl::Indices inliers(const std::vector<Point>& points, const PrefilterParams& params) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(points.size());
  for (const Point& p : points) cloud->emplace_back(p.x, p.y, p.z);

  pcl::Indices kept;
  if (params.outliers == "radius") {
    pcl::RadiusOutlierRemoval<pcl::PointXYZ> filter;
    filter.setInputCloud(cloud);
    filter.setRadiusSearch(params.outlier_radius);
    filter.setMinNeighborsInRadius(params.outlier_neighbours);
    filter.filter(kept);
  } else {
    pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
    filter.setInputCloud(cloud);
    filter.setMeanK(params.outlier_neighbours);
    filter.setStddevMulThresh(params.outlier_sigmas);
    filter.filter(kept);
  }
  return kept;
}

}  // namespace

int remove_outliers(std::vector<Point>& points, const PrefilterParams& params) {
  // PCL's searches need more points than neighbours; so few points say nothing about which of them is an outlier.
  if (params.outliers == "none" || points.size() <= static_cast<std::size_t>(params.outlier_neighbours)) return 0;
  const std::size_t before = points.size();
  std::size_t next = 0;
  for (const int index : inliers(points, params)) points[next++] = points[static_cast<std::size_t>(index)];
  points.resize(next);
  return static_cast<int>(before - next);
}

}  // namespace sgraph
