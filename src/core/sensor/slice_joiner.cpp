#include "sgraph_slam/core/sensor/slice_joiner.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "azimuth.hpp"
#include "sgraph_slam/core/sensor/cloud_look.hpp"

namespace sgraph {

void SliceJoiner::add(Cloud cloud, std::vector<CloudPtr>& scans) {
  RawScan slice;
  slice.cloud = std::move(cloud);
  slice.has_ring = true;
  const CloudLook look = look_at(slice, std::nullopt);
  double length = look.swept != 0 ? std::abs(look.swept) : look.coverage;
  // What returned nothing between two slices has been swept too.
  if (!joined_.empty()) length += std::clamp(turn_sign_ * wrapped(look.begin - joined_end_), 0.0, 0.5 * M_PI);
  const auto hand_out = [&] {
    if (!joined_.empty()) scans.push_back(std::make_shared<const Cloud>(std::move(joined_)));
    joined_ = Cloud();
    joined_sweep_ = 0;
  };
  if (!joined_.empty() && std::abs(slice.cloud.stamp - joined_.stamp) > turn_) hand_out();  // slices are missing, or time has jumped
  const double moved = joined_.empty() ? 0.0 : slice.cloud.stamp - joined_.stamp;
  for (Point& p : joined_.points) p.time -= static_cast<float>(moved);
  joined_.stamp = slice.cloud.stamp;
  joined_.frame = slice.cloud.frame;
  joined_.points.insert(joined_.points.end(), slice.cloud.points.begin(), slice.cloud.points.end());
  joined_sweep_ += length;
  joined_end_ = look.end;
  if (joined_sweep_ + 0.5 * length >= full_turn) hand_out();
}

}  // namespace sgraph
