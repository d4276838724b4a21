#pragma once

#include <vector>

#include <sensor_msgs/PointCloud2.h>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// The cloud with a colour for each segment (x y z rgb, as rviz shows it); points of no segment (label -1) are grey. One label a point.
sensor_msgs::PointCloud2 colored_cloud(const Cloud& cloud, const std::vector<int>& labels);

}  // namespace sgraph
