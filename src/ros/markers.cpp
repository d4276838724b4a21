#include "sgraph_slam/ros/markers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>

#include "sgraph_slam/core/math/outline_area.hpp"
#include "sgraph_slam/core/math/signed_area.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/messages.hpp"

namespace sgraph {

namespace {

using visualization_msgs::Marker;

struct Color {
  float r, g, b, a;
};

constexpr Color keyframe_color{0.20F, 0.65F, 1.00F, 1.0F};
constexpr Color path_color{0.10F, 0.45F, 0.85F, 1.0F};
constexpr Color x_color{0.95F, 0.45F, 0.25F, 0.5F};
constexpr Color y_color{0.30F, 0.75F, 0.40F, 0.5F};
constexpr Color horizontal_color{0.60F, 0.60F, 0.65F, 0.9F};
constexpr Color other_color{0.80F, 0.70F, 0.30F, 0.5F};
constexpr Color room_color{0.95F, 0.30F, 0.75F, 1.0F};
constexpr Color corridor_color{0.95F, 0.80F, 0.20F, 1.0F};
constexpr Color opening_color{0.90F, 0.90F, 0.90F, 1.0F};
constexpr Color door_color{0.35F, 0.90F, 1.00F, 1.0F};  // no wall's
constexpr Color storey_color{0.55F, 0.95F, 0.45F, 1.0F};
constexpr Color text_color{1.0F, 1.0F, 1.0F, 1.0F};

/// Planes below this area are drawn as small ones [m^2]: a table's top is about 1.3, the piece of wall beside a door 2.
constexpr double small_area = 1.5;

std_msgs::ColorRGBA to_message(const Color& color) {
  std_msgs::ColorRGBA message;
  message.r = color.r;
  message.g = color.g;
  message.b = color.b;
  message.a = color.a;
  return message;
}

Color color_of(PlaneClass plane_class) {
  switch (plane_class) {
    case PlaneClass::x: return x_color;
    case PlaneClass::y: return y_color;
    case PlaneClass::horizontal: return horizontal_color;
    case PlaneClass::unclassified: break;
  }
  return other_color;
}

geometry_msgs::Point at(const Eigen::Vector3d& p, double lift) {
  geometry_msgs::Point message;
  message.x = p.x();
  message.y = p.y();
  message.z = p.z() + lift;
  return message;
}

/// The point of a wall (of the rectangle around its outline) that is nearest to `p`: a line to a long wall's middle would leave the room.
Eigen::Vector3d nearest_on(const ScenePlane& plane, const Eigen::Vector3d& p) {
  const Eigen::Vector3d& n = plane.plane.normal;
  const Eigen::Vector3d along = Eigen::Vector3d::UnitZ().cross(n).normalized();
  const Eigen::Vector3d up = n.cross(along);
  const auto clamped = [&](const Eigen::Vector3d& axis) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const Eigen::Vector3d& corner : plane.extent) {
      low = std::min(low, axis.dot(corner));
      high = std::max(high, axis.dot(corner));
    }
    return std::clamp(axis.dot(p), low, high);
  };
  return clamped(along) * along + clamped(up) * up - plane.plane.d * n;
}

Eigen::Vector3d middle(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return points.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(points.size()));
}

/// Collects the markers of one snapshot.
class Drawing {
 public:
  Drawing(const GraphSnapshot& snapshot, double layer_height)
      : snapshot_(snapshot), planes_lift_(layer_height), places_lift_(2 * layer_height), storeys_lift_(3 * layer_height) {
    Marker erase = marker("", Marker::CUBE, {0, 0, 0, 0}, 1);
    erase.action = Marker::DELETEALL;
    array_.markers.push_back(erase);
  }

  void keyframes() {
    if (snapshot_.keyframes.empty()) return;
    Marker nodes = marker("keyframes", Marker::SPHERE_LIST, keyframe_color, 0.22);
    Marker edges = marker("keyframe_edges", Marker::LINE_STRIP, path_color, 0.06);
    for (const auto& [id, keyframe] : snapshot_.keyframes) {
      nodes.points.push_back(at(keyframe.T_map_base.translation, 0));
      edges.points.push_back(at(keyframe.T_map_base.translation, 0));
    }
    array_.markers.push_back(nodes);
    if (edges.points.size() > 1) array_.markers.push_back(edges);
  }

  void planes() {
    const std::set<PlaneId> of_places = planes_of_places();
    for (const auto& [id, plane] : snapshot_.planes) {
      if (plane.extent.size() < 3) continue;
      const Color color = color_of(plane.plane_class);
      if (of_places.count(id) == 0 && outline_area(plane.extent) < small_area) {
        small_plane(plane, color);
        continue;
      }
      if (plane.plane_class != PlaneClass::horizontal) fill(plane, color);  // a filled floor or ceiling would hide what is below
      Marker outline = marker("plane_outlines", Marker::LINE_STRIP, {color.r, color.g, color.b, 1}, 0.04);
      outline.id = static_cast<int>(id.value);
      for (std::size_t i = 0; i <= plane.extent.size(); ++i) outline.points.push_back(at(plane.extent[i % plane.extent.size()], planes_lift_));
      array_.markers.push_back(outline);
    }
    observations();
  }

  void places() {
    char label[80];
    for (const auto& [id, room] : snapshot_.rooms) {
      if (room.is_rectangle()) {
        std::snprintf(label, sizeof label, "room %ld\n%.2f x %.2f m", static_cast<long>(id.value), room.width.x(), room.width.y());
      } else {
        std::snprintf(label, sizeof label, "room %ld\n%.1f m2", static_cast<long>(id.value), signed_area(room.polygon, room.holes));
      }
      outline("room_outlines", static_cast<int>(id.value), room.polygon, room.center.z(), room_color);
      place("rooms", static_cast<int>(id.value), room.center, room.planes, room_color, label);
    }
    for (const auto& [id, corridor] : snapshot_.corridors) {
      std::snprintf(label, sizeof label, "corridor %ld\n%.2f m wide", static_cast<long>(id.value), corridor.width);
      outline("corridor_outlines", static_cast<int>(id.value), corridor.polygon, corridor.center.z(), corridor_color);
      place("corridors", static_cast<int>(id.value), corridor.center, corridor.planes, corridor_color, label);
    }
    openings();
    doors();
    storeys();
  }

  visualization_msgs::MarkerArray take() { return std::move(array_); }

 private:
  [[nodiscard]] Marker marker(const std::string& name, int type, const Color& color, double size) const {
    Marker result;
    result.header.frame_id = snapshot_.frame;
    if (!snapshot_.keyframes.empty()) result.header.stamp = to_ros_time(snapshot_.keyframes.rbegin()->second.stamp);
    result.ns = name;
    result.type = type;
    result.color = to_message(color);
    result.scale.x = result.scale.y = result.scale.z = size;
    result.pose.orientation.w = 1;
    return result;
  }

  void fill(const ScenePlane& plane, const Color& color) {
    Marker face = marker("planes", Marker::TRIANGLE_LIST, color, 1);
    face.id = static_cast<int>(plane.id.value);
    for (std::size_t i = 2; i < plane.extent.size(); ++i)
      for (const std::size_t corner : {std::size_t{0}, i - 1, i}) face.points.push_back(at(plane.extent[corner], planes_lift_));
    face.colors.assign(face.points.size(), face.color);  // rviz lights a face without them from one side only
    array_.markers.push_back(face);
  }

  /// The planes that bound rooms and corridors: shown however small they are.
  [[nodiscard]] std::set<PlaneId> planes_of_places() const {
    std::set<PlaneId> all;
    for (const auto& [id, room] : snapshot_.rooms) all.insert(room.planes.begin(), room.planes.end());
    for (const auto& [id, corridor] : snapshot_.corridors) all.insert(corridor.planes.begin(), corridor.planes.end());
    return all;
  }

  /// Furniture, mostly: hundreds in an office. A thin outline in a namespace of its own, which a viewer can leave out.
  void small_plane(const ScenePlane& plane, const Color& color) {
    Marker outline = marker("small_planes", Marker::LINE_STRIP, {color.r, color.g, color.b, 0.35F}, 0.015);
    outline.id = static_cast<int>(plane.id.value);
    for (std::size_t i = 0; i <= plane.extent.size(); ++i) outline.points.push_back(at(plane.extent[i % plane.extent.size()], planes_lift_));
    array_.markers.push_back(outline);
  }

  /// From each keyframe to the walls that it saw: a marker a keyframe, so that old ones need not be sent again.
  void observations() {
    std::map<KeyframeId, Marker> of_keyframes;
    for (const auto& [id, plane] : snapshot_.planes) {
      if (plane.plane_class == PlaneClass::horizontal || plane.extent.empty()) continue;
      const Eigen::Vector3d center = middle(plane.extent);
      for (const KeyframeId keyframe : plane.keyframes) {
        const auto found = snapshot_.keyframes.find(keyframe);
        if (found == snapshot_.keyframes.end()) continue;
        auto [lines, is_new] = of_keyframes.try_emplace(keyframe);
        if (is_new) {
          lines->second = marker("observations", Marker::LINE_LIST, {0.7F, 0.7F, 0.7F, 0.35F}, 0.015);
          lines->second.id = static_cast<int>(keyframe.value);
        }
        lines->second.points.push_back(at(center, planes_lift_));
        lines->second.points.push_back(at(found->second.T_map_base.translation, 0));
      }
    }
    for (auto& [keyframe, lines] : of_keyframes) array_.markers.push_back(std::move(lines));
  }

  void place(const std::string& name, int id, const Eigen::Vector3d& center, const std::vector<PlaneId>& planes, const Color& color,
             const char* label) {
    Marker node = marker(name, Marker::CUBE, color, 0.6);
    node.id = id;
    node.pose.position = at(center, places_lift_);
    array_.markers.push_back(node);

    Marker lines = marker(name + "_walls", Marker::LINE_LIST, color, 0.05);
    lines.id = id;
    for (const PlaneId plane : planes) {
      const auto found = snapshot_.planes.find(plane);
      if (found == snapshot_.planes.end() || found->second.extent.empty()) continue;
      lines.points.push_back(at(center, places_lift_));
      lines.points.push_back(at(nearest_on(found->second, center), planes_lift_));
    }
    if (!lines.points.empty()) array_.markers.push_back(lines);
    write(name + "_labels", id, center, places_lift_ + 1.5, label);
  }

  void write(const std::string& name, int id, const Eigen::Vector3d& below, double lift, const char* words) {
    Marker text = marker(name, Marker::TEXT_VIEW_FACING, text_color, 0.7);
    text.id = id;
    text.pose.position = at(below, lift);
    text.text = words;
    array_.markers.push_back(text);
  }

  /// The inner outline, on the planes' layer.
  void outline(const std::string& name, int id, const std::vector<Eigen::Vector2d>& polygon, double z, const Color& color) {
    if (polygon.empty()) return;
    Marker line = marker(name, Marker::LINE_STRIP, color, 0.06);
    line.id = id;
    for (std::size_t i = 0; i <= polygon.size(); ++i) {
      const Eigen::Vector2d& corner = polygon[i % polygon.size()];
      line.points.push_back(at({corner.x(), corner.y(), z}, planes_lift_));
    }
    array_.markers.push_back(line);
  }

  /// Frames of jambs and lintel; on the lintel the door's node, with edges to the places that it joins.
  void doors() {
    Marker frames = marker("doors", Marker::LINE_LIST, door_color, 0.05);
    Marker nodes = marker("door_nodes", Marker::SPHERE_LIST, door_color, 0.25);
    Marker edges = marker("door_edges", Marker::LINE_LIST, door_color, 0.03);
    for (const auto& [id, door] : snapshot_.doors) {
      const Eigen::Vector3d along(-std::sin(door.yaw), std::cos(door.yaw), 0);
      const Eigen::Vector3d up(0, 0, door.height > 0 ? door.height : 2.0);
      const Eigen::Vector3d a = door.position - 0.5 * door.width * along;
      const Eigen::Vector3d b = door.position + 0.5 * door.width * along;
      for (const auto& [from, to] : {std::pair<Eigen::Vector3d, Eigen::Vector3d>(a, a + up), {a + up, b + up}, {b + up, b}, {b, a}}) {
        frames.points.push_back(at(from, planes_lift_));
        frames.points.push_back(at(to, planes_lift_));
      }
      nodes.points.push_back(at(door.position + up, planes_lift_));
      for (const std::string& place : {door.from, door.to}) {
        const std::optional<Eigen::Vector3d> center = center_of(place);
        if (!center) continue;
        edges.points.push_back(at(*center, places_lift_));
        edges.points.push_back(nodes.points.back());
      }
    }
    for (const Marker& all : {frames, nodes, edges})
      if (!all.points.empty()) array_.markers.push_back(all);
  }

  /// Between the nodes of the places that they join, where no door does.
  void openings() {
    std::set<std::pair<std::string, std::string>> by_doors;
    for (const auto& [id, door] : snapshot_.doors) by_doors.insert(std::minmax(door.from, door.to));
    Marker lines = marker("openings", Marker::LINE_LIST, opening_color, 0.05);
    for (const SceneOpening& opening : snapshot_.openings) {
      if (by_doors.count(std::minmax(opening.from, opening.to)) > 0) continue;
      const std::optional<Eigen::Vector3d> from = center_of(opening.from);
      const std::optional<Eigen::Vector3d> to = center_of(opening.to);
      if (!from || !to) continue;
      lines.points.push_back(at(*from, places_lift_));
      lines.points.push_back(at(*to, places_lift_));
    }
    if (!lines.points.empty()) array_.markers.push_back(lines);
  }

  /// A node above the places of each storey, with edges to them. Of a building with one storey it would say nothing.
  void storeys() {
    std::map<int, std::vector<Eigen::Vector3d>> places;
    for (const auto& [id, room] : snapshot_.rooms) places[room.storey].push_back(room.center);
    for (const auto& [id, corridor] : snapshot_.corridors) places[corridor.storey].push_back(corridor.center);
    if (snapshot_.storeys.size() < 2) return;
    for (const SceneStorey& storey : snapshot_.storeys) {
      const auto centers = places.find(storey.id);
      if (centers == places.end()) continue;
      const Eigen::Vector3d center = middle(centers->second);
      Marker node = marker("storeys", Marker::CUBE, storey_color, 0.8);
      node.id = storey.id;
      node.pose.position = at(center, storeys_lift_);
      array_.markers.push_back(node);
      Marker lines = marker("storeys_places", Marker::LINE_LIST, storey_color, 0.05);
      lines.id = storey.id;
      for (const Eigen::Vector3d& place : centers->second) {
        lines.points.push_back(node.pose.position);
        lines.points.push_back(at(place, places_lift_));
      }
      array_.markers.push_back(lines);
      char label[80];
      std::snprintf(label, sizeof label, "storey %d\nfloor at %.2f m", storey.id, storey.z);
      write("storeys_labels", storey.id, center, storeys_lift_ + 1.5, label);
    }
  }

  /// Of "room/3" or "corridor/0".
  [[nodiscard]] std::optional<Eigen::Vector3d> center_of(const std::string& place) const {
    long id = 0;
    if (std::sscanf(place.c_str(), "room/%ld", &id) == 1) {
      const auto room = snapshot_.rooms.find({id});
      if (room != snapshot_.rooms.end()) return room->second.center;
    }
    if (std::sscanf(place.c_str(), "corridor/%ld", &id) == 1) {
      const auto corridor = snapshot_.corridors.find({id});
      if (corridor != snapshot_.corridors.end()) return corridor->second.center;
    }
    return {};
  }

  const GraphSnapshot& snapshot_;
  const double planes_lift_;
  const double places_lift_;
  const double storeys_lift_;
  visualization_msgs::MarkerArray array_;
};

}  // namespace

namespace {

/// FNV-1a over what a marker looks like, lengths rounded to a centimetre; the stamp doesn't show.
class Look {
 public:
  explicit Look(const Marker& marker) {
    add(static_cast<std::uint64_t>(marker.type));
    for (const double value : {marker.scale.x, marker.scale.y, marker.scale.z, marker.pose.orientation.x, marker.pose.orientation.y,
                               marker.pose.orientation.z, marker.pose.orientation.w})
      add(static_cast<std::uint64_t>(std::llround(1000 * value)));
    for (const float value : {marker.color.r, marker.color.g, marker.color.b, marker.color.a})
      add(static_cast<std::uint64_t>(std::lround(255 * value)));
    add(marker.pose.position);
    for (const geometry_msgs::Point& point : marker.points) add(point);
    for (const char c : marker.text) add(static_cast<std::uint64_t>(c));
    for (const char c : marker.header.frame_id) add(static_cast<std::uint64_t>(c));
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  void add(std::uint64_t part) { value_ = (value_ ^ part) * 1099511628211ULL; }
  void add(const geometry_msgs::Point& p) {
    for (const double value : {p.x, p.y, p.z}) add(static_cast<std::uint64_t>(std::llround(100 * value)));
  }

  std::uint64_t value_ = 14695981039346656037ULL;
};

}  // namespace

visualization_msgs::MarkerArray MarkerChanges::since_last(const visualization_msgs::MarkerArray& drawing, bool whole) {
  visualization_msgs::MarkerArray changes;
  std::map<std::pair<std::string, int>, std::uint64_t> now;
  for (const Marker& marker : drawing.markers) {
    if (marker.action != Marker::ADD) continue;
    const std::pair<std::string, int> name{marker.ns, marker.id};
    const std::uint64_t look = Look(marker).value();
    now[name] = look;
    const auto before = sent_.find(name);
    if (before == sent_.end() || before->second != look) changes.markers.push_back(marker);
  }
  for (const auto& [name, look] : sent_) {
    if (now.count(name) > 0) continue;
    Marker gone;
    if (!drawing.markers.empty()) gone.header = drawing.markers.front().header;
    gone.ns = name.first;
    gone.id = name.second;
    gone.action = Marker::DELETE;
    changes.markers.push_back(gone);
  }
  sent_ = std::move(now);
  return whole ? drawing : changes;
}

visualization_msgs::MarkerArray graph_markers(const GraphSnapshot& snapshot, double layer_height) {
  Drawing drawing(snapshot, layer_height);
  drawing.keyframes();
  drawing.planes();
  drawing.places();
  return drawing.take();
}

}  // namespace sgraph
