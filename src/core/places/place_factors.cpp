#include "sgraph_slam/core/places/place_factors.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

constexpr double min_faces_overlap = 1.0;  // of the two faces of a wall [m]
constexpr double max_thickness = 0.5;      // [m]
constexpr std::size_t min_views = 3;       // of each face
constexpr std::size_t min_walls = 4;       // whose thicknesses agree

// Of each plane the largest segment that was taken for it. A plane may have been merged since.
std::map<PlaneId, const PlaneSegment*> segments_of_planes(const Graph& graph, const PlaneSegments& segments, const std::vector<PlaneId>& planes) {
  std::map<PlaneId, const PlaneSegment*> seen;
  for (std::size_t i = 0; i < std::min(planes.size(), segments.segments.size()); ++i) {
    if (!planes[i].valid()) continue;
    const PlaneSegment*& largest = seen[graph.representative(planes[i])];
    if (!largest || largest->count < segments.segments[i].count) largest = &segments.segments[i];
  }
  return seen;
}

struct SeenWidth {
  double width;
  double sigma;
};

// Distance between two facing segments midway between their centroids, and its standard deviation there.
std::optional<SeenWidth> seen_width(const PlaneSegment* a, const PlaneSegment* b, double added_sigma) {
  if (!a || !b) return std::nullopt;
  const Eigen::Vector3d middle = 0.5 * (a->centroid + b->centroid);
  const double half_a = (middle - a->centroid).norm();
  const double half_b = (middle - b->centroid).norm();
  const double angle2 = a->covariance.topLeftCorner<2, 2>().trace() * half_a * half_a + b->covariance.topLeftCorner<2, 2>().trace() * half_b * half_b;
  return SeenWidth{a->plane.distance(middle) + b->plane.distance(middle), std::sqrt(angle2 + added_sigma * added_sigma)};
}

// The faces of a place's sides.
std::vector<PlaneId> known_walls(const FoundPlace& place) {
  std::vector<PlaneId> walls;
  for (const PlaceSide& side : place.outline.sides) {
    if (side.plane.valid()) walls.push_back(side.plane);
  }
  return walls;
}

double place_height(const Graph& graph, const PlaneMap& planes, const Eigen::Vector2d& center, const std::vector<PlaneId>& walls, int storey) {
  std::optional<double> floor;
  std::optional<double> ceiling;
  double wall_sum = 0;
  for (const PlaneId id : walls) {
    const PlaneRecord* record = planes.find(id);
    wall_sum += record ? outline_center(record->outline).z() : 0;
  }
  const double middle = walls.empty() ? 0 : wall_sum / static_cast<double>(walls.size());
  for (const auto& [id, record] : planes.records()) {
    if (record.plane_class != PlaneClass::horizontal || record.storey != storey) continue;
    const Plane& plane = *graph.find(id);
    const double z = -(plane.d + plane.normal.head<2>().dot(center)) / plane.normal.z();
    const Eigen::Vector3d foot(center.x(), center.y(), z);
    if (outline_distance(plane, record.outline, {foot}) > 0.5) continue;
    if (plane.normal.z() > 0 && z < middle) floor = floor ? std::min(*floor, z) : z;
    if (plane.normal.z() < 0 && z > middle) ceiling = ceiling ? std::max(*ceiling, z) : z;
  }
  return floor && ceiling ? 0.5 * (*floor + *ceiling) : middle;
}

}  // namespace

void add_widths(Committer& committer, const TopologicalLayer& layer, const PlaneSegments& segments, const std::vector<PlaneId>& planes,
                const TopologyParams& params) {
  if (!params.width_factors) return;
  const auto seen = segments_of_planes(committer.graph, segments, planes);
  const KeyframeId now = committer.newest();
  const auto segment_of = [&](PlaneId id) {
    const auto found = seen.find(id);
    return found == seen.end() ? nullptr : found->second;
  };
  Transaction edit;
  edit.reason = "widths seen by keyframe/" + std::to_string(now.value);
  const RobustLoss loss = RobustLoss::cauchy(params.loss_scale);
  for (const auto& [id, room] : layer.rooms()) {
    if (!committer.graph.find(id) || room.place.kind != PlaceKind::room) continue;
    for (const int axis : {0, 1}) {
      const auto& walls = room.place.walls;
      const std::size_t first = 2 * static_cast<std::size_t>(axis);
      const auto width = seen_width(segment_of(walls[first]), segment_of(walls[first + 1]), params.width_sigma);
      if (width && width->width > 0) add_factor(edit, RoomWidth{id, now, axis, width->width, width->sigma}, loss);
    }
  }
  for (const auto& [id, corridor] : layer.corridors()) {
    if (!committer.graph.find(id)) continue;
    const auto width = seen_width(segment_of(corridor.place.walls[0]), segment_of(corridor.place.walls[1]), params.width_sigma);
    if (width && width->width > 0) add_factor(edit, CorridorWidth{id, now, width->width, width->sigma}, loss);
  }
  if (!edit.factors.empty()) committer.commit(edit);
}

void add_wall_faces(Committer& committer, const PlaneMap& planes, double max_angle, const TopologyParams& params) {
  if (!params.thickness_factors) return;
  struct Faces {
    PlanePair planes;
    double thickness;
    Eigen::Vector3d point;
  };
  std::vector<Faces> all;
  const std::vector<Wall> walls = planes.walls();
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (std::size_t k = i + 1; k < walls.size(); ++k) {
      const auto pair = facing_pair(walls[i], walls[k], max_angle);
      if (!pair || pair->width > -0.03 || pair->width < -max_thickness || pair->common.length() < min_faces_overlap) continue;
      const PlaneRecord& a = *planes.find(walls[i].id);
      const PlaneRecord& b = *planes.find(walls[k].id);
      if (a.storey != b.storey) continue;
      if (a.keyframes.size() < min_views || b.keyframes.size() < min_views) continue;
      const Eigen::Vector2d along(-pair->axis.y(), pair->axis.x());
      const Eigen::Vector2d at = pair->common.center() * along + 0.5 * (pair->s1 + pair->s2) * pair->axis;
      all.push_back({{walls[i].id, walls[k].id}, -pair->width, {at.x(), at.y(), outline_center(a.outline).z()}});
    }
  }
  if (all.size() < min_walls) return;
  std::vector<double> thicknesses;
  for (const Faces& faces : all) thicknesses.push_back(faces.thickness);
  const double usual = upper_median(std::move(thicknesses));
  Transaction edit;
  edit.reason = "faces of walls";
  for (const auto& [id, factor] : committer.graph.factors()) {
    if (std::holds_alternative<WallThickness>(factor.data)) edit.remove_factors.push_back(id);
  }
  for (const Faces& faces : all) {
    if (std::abs(faces.thickness - usual) > 2 * params.thickness_sigma) continue;
    add_factor(edit, WallThickness{faces.planes.first, faces.planes.second, usual, params.thickness_sigma, faces.point},
               RobustLoss::cauchy(params.loss_scale));
  }
  committer.commit(edit);
}

void synchronise(Committer& committer, const TopologicalLayer& layer, const PlaneMap& planes, const TopologyParams& params) {
  PlaceHeights heights;
  for (const auto& [id, room] : layer.rooms()) {
    heights.rooms[id] = place_height(committer.graph, planes, room.place.reference_point(), known_walls(room.place), room.storey);
  }
  for (const auto& [id, corridor] : layer.corridors()) {
    heights.corridors[id] = place_height(committer.graph, planes, corridor.place.reference_point(), known_walls(corridor.place), corridor.storey);
  }
  const Transaction edit = synchronise_topology(committer.graph, layer, planes, heights, params);
  const bool empty =
      edit.rooms.empty() && edit.corridors.empty() && edit.factors.empty() && edit.remove_factors.empty() && edit.remove_variables.empty();
  if (!empty && !committer.commit(edit).ok()) return;
  // What the graph holds constant follows the walls; position and width start from them too.
  for (const auto& [id, room] : layer.rooms()) {
    if (!room.place.has_node()) continue;
    const auto& area = room.place.area;
    committer.graph.set(id, Room::at({area.center.x(), area.center.y(), heights.rooms[id]}, area.yaw, area.size));
  }
  for (const auto& [id, corridor] : layer.corridors()) {
    const auto& area = corridor.place.area;
    committer.graph.set(id, Corridor::at({area.center.x(), area.center.y(), heights.corridors[id]}, area.yaw, area.size.y()));
  }
}

}  // namespace sgraph
