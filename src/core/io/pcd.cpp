#include <stdexcept>

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include "sgraph_slam/core/io/pcd.hpp"

namespace sgraph {

std::vector<Eigen::Vector3f> read_pcd_positions(const std::string& path) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  if (pcl::io::loadPCDFile(path, cloud) < 0) throw std::runtime_error("cannot read " + path + " as a point cloud");
  std::vector<Eigen::Vector3f> points;
  points.reserve(cloud.size());
  for (const pcl::PointXYZ& p : cloud) {
    if (p.getVector3fMap().allFinite()) points.push_back(p.getVector3fMap());
  }
  return points;
}

}  // namespace sgraph
