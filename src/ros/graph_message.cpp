#include "message_parts.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/messages.hpp"

namespace sgraph {

namespace {

using Ids = std::vector<std::int64_t>;

template <class Range>
Ids ids_of(const Range& range) {
  Ids ids;
  ids.reserve(range.size());
  for (const auto id : range) ids.push_back(id.value);
  return ids;
}

std::vector<PlaneId> plane_ids(const Ids& ids) {
  std::vector<PlaneId> result;
  result.reserve(ids.size());
  for (const std::int64_t id : ids) result.push_back({id});
  return result;
}

sgraph_slam::SceneKeyframe to_message(const SceneKeyframe& keyframe) {
  sgraph_slam::SceneKeyframe message;
  message.id = keyframe.id.value;
  message.stamp = to_ros_time(keyframe.stamp);
  message.pose = to_message(keyframe.T_map_base);
  message.odom_pose = to_message(keyframe.T_odom_base);
  message.storey = keyframe.storey;
  return message;
}

sgraph_slam::ScenePlane to_message(const ScenePlane& plane) {
  sgraph_slam::ScenePlane message;
  message.id = plane.id.value;
  message.plane_class = static_cast<std::uint8_t>(plane.plane_class);
  message.normal = to_vector(plane.plane.normal);
  message.d = plane.plane.d;
  to_rows<3>(plane.covariance, message.covariance);
  message.extent = to_points(plane.extent);
  message.keyframes = ids_of(plane.keyframes);
  message.storey = plane.storey;
  return message;
}

sgraph_slam::SceneSide to_message(const SceneSide& side) {
  sgraph_slam::SceneSide message;
  message.kind = static_cast<std::uint8_t>(side.kind);
  message.plane = side.plane.value;
  message.door = side.door.value;
  return message;
}

template <class Place, class Message>
void write_outline(const Place& place, Message& message) {
  for (const Eigen::Vector2d& corner : place.polygon) message.polygon.push_back(to_point({corner.x(), corner.y(), 0}));
  for (const SceneSide& side : place.edges) message.edges.push_back(to_message(side));
  message.storey = place.storey;
}

/// False when it isn't good.
template <class Place, class Message>
bool read_outline(const Message& message, Place& place) {
  if (message.edges.size() != message.polygon.size()) return false;
  for (const geometry_msgs::Point& corner : message.polygon) {
    if (!std::isfinite(corner.x) || !std::isfinite(corner.y)) return false;
    place.polygon.emplace_back(corner.x, corner.y);
  }
  for (const sgraph_slam::SceneSide& side : message.edges) {
    if (side.kind > sgraph_slam::SceneSide::OPENING) return false;
    place.edges.push_back({static_cast<SceneSide::Kind>(side.kind), {side.plane}, {side.door}});
  }
  place.storey = message.storey;
  return true;
}

using Corners = std::vector<Eigen::Vector2d>;

std::vector<geometry_msgs::Polygon> holes_to_message(const std::vector<Corners>& holes) {
  std::vector<geometry_msgs::Polygon> messages;
  for (const Corners& hole : holes) {
    geometry_msgs::Polygon& message = messages.emplace_back();
    for (const Eigen::Vector2d& corner : hole) {
      geometry_msgs::Point32& point = message.points.emplace_back();
      point.x = static_cast<float>(corner.x());
      point.y = static_cast<float>(corner.y());
    }
  }
  return messages;
}

/// False when it isn't good.
bool read_holes(const std::vector<geometry_msgs::Polygon>& messages, std::vector<Corners>& holes) {
  for (const geometry_msgs::Polygon& message : messages) {
    Corners& hole = holes.emplace_back();
    for (const geometry_msgs::Point32& point : message.points) {
      if (!std::isfinite(point.x) || !std::isfinite(point.y)) return false;
      hole.emplace_back(point.x, point.y);
    }
  }
  return true;
}

sgraph_slam::SceneBranching to_message(const SceneBranching& branching) {
  sgraph_slam::SceneBranching message;
  message.parts = ids_of(branching.parts);
  write_outline(branching, message);
  message.holes = holes_to_message(branching.holes);
  return message;
}

sgraph_slam::SceneDoor to_message(const SceneDoor& door) {
  sgraph_slam::SceneDoor message;
  message.id = door.id.value;
  message.from = door.from;
  message.to = door.to;
  message.position = to_point(door.position);
  message.yaw = door.yaw;
  message.width = door.width;
  message.height = door.height;
  message.storey = door.storey;
  return message;
}

sgraph_slam::SceneRoom to_message(const SceneRoom& room) {
  sgraph_slam::SceneRoom message;
  message.id = room.id.value;
  message.center = to_point(room.center);
  message.width[0] = room.width.x();
  message.width[1] = room.width.y();
  message.yaw = room.yaw;
  message.planes = ids_of(room.planes);
  write_outline(room, message);
  message.holes = holes_to_message(room.holes);
  return message;
}

sgraph_slam::SceneCorridor to_message(const SceneCorridor& corridor) {
  sgraph_slam::SceneCorridor message;
  message.id = corridor.id.value;
  message.center = to_point(corridor.center);
  message.width = corridor.width;
  message.yaw = corridor.yaw;
  message.length = corridor.length;
  message.planes = ids_of(corridor.planes);
  write_outline(corridor, message);
  return message;
}

sgraph_slam::SceneOpening to_message(const SceneOpening& opening) {
  sgraph_slam::SceneOpening message;
  message.from = opening.from;
  message.to = opening.to;
  message.position = to_point(opening.position);
  return message;
}

std::optional<SceneKeyframe> value_of(const sgraph_slam::SceneKeyframe& message) {
  const std::optional<Pose> pose = from_message(message.pose);
  const std::optional<Pose> odom_pose = from_message(message.odom_pose);
  if (!pose || !odom_pose) return {};
  SceneKeyframe keyframe;
  keyframe.id = {message.id};
  keyframe.stamp = to_stamp(message.stamp);
  keyframe.T_map_base = *pose;
  keyframe.T_odom_base = *odom_pose;
  keyframe.storey = message.storey;
  return keyframe;
}

std::optional<ScenePlane> value_of(const sgraph_slam::ScenePlane& message) {
  ScenePlane plane;
  plane.id = {message.id};
  plane.plane = {vector_of(message.normal), message.d};
  plane.covariance = from_rows<3>(message.covariance);
  plane.extent = points_of(message.extent);
  for (const std::int64_t id : message.keyframes) plane.keyframes.insert({id});
  const bool numbers = std::isfinite(message.d) && plane.covariance.allFinite() && finite(plane.extent);
  if (!numbers || !is_unit(plane.plane.normal) || message.plane_class > sgraph_slam::ScenePlane::UNCLASSIFIED) return {};
  plane.plane_class = static_cast<PlaneClass>(message.plane_class);
  plane.storey = message.storey;
  return plane;
}

std::optional<SceneRoom> value_of(const sgraph_slam::SceneRoom& message) {
  SceneRoom room;
  room.id = {message.id};
  room.center = vector_of(message.center);
  room.width = {message.width[0], message.width[1]};
  room.yaw = message.yaw;
  room.planes = plane_ids(message.planes);
  const bool numbers = room.center.allFinite() && room.width.allFinite() && std::isfinite(room.yaw);
  const bool planes = room.planes.size() == 4 || room.width.isZero(0);
  return numbers && planes && read_outline(message, room) && read_holes(message.holes, room.holes) ? std::optional(room) : std::nullopt;
}

std::optional<SceneCorridor> value_of(const sgraph_slam::SceneCorridor& message) {
  SceneCorridor corridor;
  corridor.id = {message.id};
  corridor.center = vector_of(message.center);
  corridor.width = message.width;
  corridor.yaw = message.yaw;
  corridor.length = message.length;
  corridor.planes = plane_ids(message.planes);
  const bool numbers = corridor.center.allFinite() && std::isfinite(corridor.width) && std::isfinite(corridor.yaw) && std::isfinite(corridor.length);
  return numbers && corridor.planes.size() == 2 && read_outline(message, corridor) ? std::optional(corridor) : std::nullopt;
}

std::optional<SceneDoor> value_of(const sgraph_slam::SceneDoor& message) {
  const SceneDoor door{{message.id}, message.from,  message.to,     vector_of(message.position),
                       message.yaw,  message.width, message.height, message.storey};
  const bool numbers = door.position.allFinite() && std::isfinite(door.yaw) && std::isfinite(door.width) && std::isfinite(door.height);
  return numbers ? std::optional(door) : std::nullopt;
}

/// The messages' values by id; false when one of them isn't good.
template <class Value, class Key, class Message>
bool read(const std::vector<Message>& messages, std::map<Key, Value>& values) {
  for (const Message& message : messages) {
    std::optional<Value> value = value_of(message);
    if (!value || !value->id.valid()) return false;
    const Key id = value->id;
    values.insert_or_assign(id, std::move(*value));
  }
  return true;
}

template <class Message, class Key, class Value>
void write(const std::map<Key, Value>& values, std::vector<Message>& messages) {
  messages.reserve(values.size());
  for (const auto& [id, value] : values) messages.push_back(to_message(value));
}

}  // namespace

static_assert(sgraph_slam::SceneSide::UNKNOWN == static_cast<int>(SceneSide::Kind::unknown));
static_assert(sgraph_slam::SceneSide::WALL == static_cast<int>(SceneSide::Kind::wall));
static_assert(sgraph_slam::SceneSide::DOOR == static_cast<int>(SceneSide::Kind::door));
static_assert(sgraph_slam::SceneSide::OPENING == static_cast<int>(SceneSide::Kind::opening));
static_assert(sgraph_slam::ScenePlane::X == static_cast<int>(PlaneClass::x));
static_assert(sgraph_slam::ScenePlane::Y == static_cast<int>(PlaneClass::y));
static_assert(sgraph_slam::ScenePlane::HORIZONTAL == static_cast<int>(PlaneClass::horizontal));
static_assert(sgraph_slam::ScenePlane::UNCLASSIFIED == static_cast<int>(PlaneClass::unclassified));

sgraph_slam::SceneGraph to_message(const GraphSnapshot& snapshot) {
  sgraph_slam::SceneGraph message;
  message.header.frame_id = snapshot.frame;
  if (!snapshot.keyframes.empty()) message.header.stamp = to_ros_time(snapshot.keyframes.rbegin()->second.stamp);
  message.version = snapshot.version;
  message.map_to_odom = to_message(snapshot.T_map_odom);
  message.dominant_yaw = snapshot.dominant_yaw;
  write(snapshot.keyframes, message.keyframes);
  write(snapshot.planes, message.planes);
  write(snapshot.rooms, message.rooms);
  write(snapshot.corridors, message.corridors);
  for (const SceneOpening& opening : snapshot.openings) message.openings.push_back(to_message(opening));
  write(snapshot.doors, message.doors);
  for (const SceneBranching& branching : snapshot.branchings) message.branchings.push_back(to_message(branching));
  for (const SceneStorey& storey : snapshot.storeys) {
    sgraph_slam::SceneStorey out;
    out.id = storey.id;
    out.z = storey.z;
    out.ceiling = storey.ceiling;
    out.height_known = static_cast<std::uint8_t>(storey.height_known);
    out.height_sigma = storey.height_sigma;
    message.storeys.push_back(out);
  }
  return message;
}

std::optional<GraphSnapshot> from_message(const sgraph_slam::SceneGraph& message) {
  const std::optional<Pose> map_to_odom = from_message(message.map_to_odom);
  GraphSnapshot snapshot;
  if (!map_to_odom || !std::isfinite(message.dominant_yaw)) return {};
  if (!read(message.keyframes, snapshot.keyframes) || !read(message.planes, snapshot.planes) || !read(message.rooms, snapshot.rooms) ||
      !read(message.corridors, snapshot.corridors) || !read(message.doors, snapshot.doors))
    return {};
  snapshot.version = message.version;
  snapshot.frame = message.header.frame_id;
  snapshot.T_map_odom = *map_to_odom;
  snapshot.dominant_yaw = message.dominant_yaw;
  for (const sgraph_slam::SceneOpening& opening : message.openings) {
    snapshot.openings.push_back({opening.from, opening.to, vector_of(opening.position)});
    if (!snapshot.openings.back().position.allFinite()) return {};
  }
  for (const sgraph_slam::SceneBranching& one : message.branchings) {
    SceneBranching& branching = snapshot.branchings.emplace_back();
    for (const std::int64_t id : one.parts) branching.parts.push_back({id});
    if (!read_outline(one, branching) || !read_holes(one.holes, branching.holes)) return {};
  }
  for (const sgraph_slam::SceneStorey& storey : message.storeys) {
    if (!std::isfinite(storey.z) || !std::isfinite(storey.ceiling) || !std::isfinite(storey.height_sigma)) return {};
    snapshot.storeys.push_back({storey.id, storey.z, storey.ceiling, storey.height_known != 0, storey.height_sigma});
  }
  return snapshot;
}

}  // namespace sgraph
