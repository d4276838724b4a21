#include "sgraph_slam/core/places/topological_layer.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "sgraph_slam/core/places/dominant_wall.hpp"

namespace sgraph {
namespace {

constexpr double same_place = 0.5;  // share of the smaller area: more in common and it is the same place
constexpr double conflict = 0.2;    // less than that, but more than this: they can't both be right
constexpr double longer = 0.5;      // gain in length that makes other walls a corridor's walls [m]
constexpr double better = 0.03;     // gain in score that makes other walls a place's walls

std::string size_text(const OrientedRectangle& area) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << area.size.x() << " m x " << area.size.y() << " m at (" << area.center.x() << ", " << area.center.y()
       << ")";
  return text.str();
}

template <std::size_t N>
std::string plane_list(const std::array<PlaneId, N>& planes) {
  std::string text;
  for (const PlaneId id : planes) text += (text.empty() ? "planes " : ", ") + std::to_string(id.value);
  return text;
}

double shared_share(const OrientedRectangle& a, const OrientedRectangle& b) {
  const double smaller = std::min(a.area(), b.area());
  return smaller > 0 ? shared_area(a, b) / smaller : 0;
}

// The same room with its sides named from another heading, nearest to `yaw`.
RoomShape turned_to(const RoomShape& room, double yaw) {
  const int turns = static_cast<int>(std::lround(std::remainder(yaw - room.area.yaw, 2 * M_PI) / (M_PI / 2)));
  RoomShape turned = room;
  constexpr std::array<Side, 4> around{high_x, high_y, low_x, low_y};
  for (int i = 0; i < 4; ++i)
    turned.walls[around[static_cast<std::size_t>(i)]] = room.walls[around[static_cast<std::size_t>(((i + turns) % 4 + 4) % 4)]];
  if (turns % 2 != 0) std::swap(turned.area.size.x(), turned.area.size.y());
  turned.area.yaw = std::remainder(room.area.yaw + turns * M_PI / 2, 2 * M_PI);
  return turned;
}

PlanePair older_first(PlaneId a, PlaneId b) { return a < b ? PlanePair{a, b} : PlanePair{b, a}; }

const Wall* find_wall(const std::vector<Wall>& walls, PlaneId id) {
  const auto found = std::find_if(walls.begin(), walls.end(), [&](const Wall& wall) { return wall.id == id; });
  return found == walls.end() ? nullptr : &*found;
}

// Of coplanar planes the best known stands for a side of the place.
template <class Shape, class Params>
void prefer_dominant_walls(const std::vector<Wall>& walls, Shape& shape, const Params& params, const std::string& name, KeyframeId now,
                           DecisionLog& log) {
  for (PlaneId& wall : shape.walls) {
    const PlaneId best = dominant_wall(walls, wall, shape.area, params.coplanar, 0.5 * params.parallel);
    if (best == wall) continue;
    log.push_back({now, true, name, "plane " + std::to_string(best.value) + " shows more of a side than plane " + std::to_string(wall.value)});
    wall = best;
  }
}

std::vector<Wall> recent_walls(const std::vector<Wall>& walls, KeyframeId now, int recent) {
  std::vector<Wall> seen;
  for (const Wall& wall : walls) {
    if (wall.last_seen.value > now.value - recent) seen.push_back(wall);
  }
  return seen;
}

}  // namespace

void TopologicalLayer::refuse(const Visit& visit, const std::string& what, const std::string& reason, DecisionLog& log) {
  if (refused_.insert(what + reason).second) log.push_back({visit.keyframe, false, what, reason});
}

bool TopologicalLayer::same_wall(const std::vector<Wall>& walls, PlaneId a, PlaneId b, const Eigen::Vector2d& near) const {
  const Wall* wall_a = find_wall(walls, a);
  const Wall* wall_b = find_wall(walls, b);
  if (!wall_a || !wall_b || wall_a->normal.dot(wall_b->normal) < std::cos(params_.merging.max_angle)) return false;
  const Eigen::Vector2d foot = near - wall_a->distance(near) * wall_a->normal;
  return std::abs(wall_b->distance(foot)) <= params_.merging.max_distance;
}

void TopologicalLayer::follow_merges(const Graph& graph) {
  for (auto& [id, room] : rooms_) {
    for (PlaneId& wall : room.shape.walls) wall = graph.representative(wall);
  }
  for (auto& [id, corridor] : corridors_) {
    for (PlaneId& wall : corridor.shape.walls) wall = graph.representative(wall);
  }
}

std::vector<PlanePair> TopologicalLayer::visit(Graph& graph, const std::vector<Wall>& walls, const Visit& visit, DecisionLog& log) {
  follow_merges(graph);
  const std::vector<Wall> recent = recent_walls(walls, visit.keyframe, params_.topology.recent);
  for (const auto* among : {&recent, &walls}) {
    if (!params_.topology.rooms) break;
    const RoomSearch search = find_room(*among, visit.position, visit.building_yaw, params_.rooms);
    if (search.room) return take_room(graph, *search.room, walls, visit, log);
  }
  const bool in_room = std::any_of(rooms_.begin(), rooms_.end(), [&](const auto& entry) { return entry.second.shape.area.contains(visit.position); });
  if (in_room) return {};
  for (const auto* among : {&walls, &recent}) {
    if (!params_.topology.corridors) break;
    const CorridorSearch search = find_corridor(*among, visit.position, visit.building_yaw, params_.corridors);
    if (search.corridor) return take_corridor(graph, *search.corridor, walls, visit, log);
  }
  return {};
}

std::vector<PlanePair> TopologicalLayer::know_again(RoomId id, RoomRecord& known, const RoomShape& found, const std::vector<Wall>& walls,
                                                    const Visit& visit, DecisionLog& log) {
  const RoomShape turned = turned_to(found, known.shape.area.yaw);
  if (turned.walls == known.shape.walls) {
    known.shape = turned;
    known.history.failures = 0;
    return {};
  }
  std::vector<PlanePair> one_wall;
  for (std::size_t side = 0; side < 4; ++side) {
    const PlaneId a = known.shape.walls[side];
    const PlaneId b = turned.walls[side];
    if (a != b && same_wall(walls, a, b, known.shape.area.center)) one_wall.push_back(older_first(a, b));
  }
  if (known.history.failures > 0 || room_score(turned) > room_score(known.shape) + better) {
    log.push_back({visit.keyframe, true, "room/" + std::to_string(id.value),
                   "better walls: " + plane_list(turned.walls) + " in place of " + plane_list(known.shape.walls) + "; " + size_text(turned.area)});
    known.shape = turned;
    known.history.failures = 0;
  }
  return one_wall;
}

std::vector<PlanePair> TopologicalLayer::take_room(Graph& graph, const RoomShape& found, const std::vector<Wall>& walls, const Visit& visit,
                                                   DecisionLog& log) {
  const std::string what = "room of " + plane_list(found.walls);
  RoomRecord* same = nullptr;
  RoomId same_id;
  double most = same_place;
  for (auto& [id, room] : rooms_) {
    const double shared = shared_share(room.shape.area, found.area);
    if (shared > most) {
      most = shared;
      same = &room;
      same_id = id;
    }
  }
  if (same) return know_again(same_id, *same, found, walls, visit, log);
  for (const auto& [id, room] : rooms_) {
    if (shared_share(room.shape.area, found.area) <= conflict) continue;
    refuse(visit, what, "overlaps room/" + std::to_string(id.value), log);
    return {};
  }
  std::optional<CorridorId> was;
  for (const auto& [id, corridor] : corridors_) {
    const double shared = shared_share(corridor.shape.area, found.area);
    // A room that is but a piece of a corridor would be one between two things standing in it.
    if (shared_area(corridor.shape.area, found.area) > same_place * corridor.shape.area.area()) {
      was = id;
    } else if (shared > conflict) {
      refuse(visit, what, "overlaps corridor/" + std::to_string(id.value), log);
      return {};
    }
  }
  const RoomId id = graph.new_room_id();
  rooms_[id] = {found, {visit.keyframe, 0, was}};
  std::string reason = "four walls (" + plane_list(found.walls) + ") around " + size_text(found.area);
  if (was) {
    corridors_.erase(*was);
    reason = "upgraded from corridor/" + std::to_string(was->value) + ", whose end walls have appeared: " + reason;
  }
  log.push_back({visit.keyframe, true, "room/" + std::to_string(id.value), reason});
  return {};
}

std::vector<PlanePair> TopologicalLayer::take_corridor(Graph& graph, const CorridorShape& found, const std::vector<Wall>& walls, const Visit& visit,
                                                       DecisionLog& log) {
  const std::string what = "corridor of " + plane_list(found.walls);
  for (const auto& [id, room] : rooms_) {
    if (shared_area(room.shape.area, found.area) <= conflict * std::min(room.shape.area.area(), found.area.area())) continue;
    refuse(visit, what, "overlaps room/" + std::to_string(id.value), log);
    return {};
  }
  for (auto& [id, known] : corridors_) {
    const bool parallel = std::abs(std::remainder(known.shape.area.yaw - found.area.yaw, M_PI)) < params_.corridors.parallel;
    if (!same_corridor(known.shape, found, params_.corridors) && (!parallel || shared_share(known.shape.area, found.area) <= same_place)) continue;
    std::vector<PlanePair> one_wall;
    const bool reversed = std::abs(std::remainder(known.shape.area.yaw - found.area.yaw, 2 * M_PI)) > M_PI / 2;
    for (std::size_t side = 0; side < 2; ++side) {
      const PlaneId a = known.shape.walls[side];
      const PlaneId b = found.walls[reversed ? 1 - side : side];
      if (a != b && same_wall(walls, a, b, found.area.center)) one_wall.push_back(older_first(a, b));
    }
    if (found.walls == known.shape.walls || known.history.failures > 0 || found.area.size.x() > known.shape.area.size.x() + longer)
      known.shape = found;
    known.history.failures = 0;
    return one_wall;
  }
  const CorridorId id = graph.new_corridor_id();
  corridors_[id] = {found, {visit.keyframe, 0, std::nullopt}};
  log.push_back(
      {visit.keyframe, true, "corridor/" + std::to_string(id.value), "two facing walls (" + plane_list(found.walls) + "), " + size_text(found.area)});
  return {};
}

void TopologicalLayer::judge_rooms(const std::vector<Wall>& walls, const std::set<PlaneId>* touched, KeyframeId now, DecisionLog& log) {
  for (auto room = rooms_.begin(); room != rooms_.end();) {
    RoomShape& shape = room->second.shape;
    const auto concerned = [&](PlaneId id) { return touched->count(id) > 0; };
    if (touched && std::none_of(shape.walls.begin(), shape.walls.end(), concerned)) {
      ++room;
      continue;
    }
    const std::string name = "room/" + std::to_string(room->first.value);
    prefer_dominant_walls(walls, shape, params_.rooms, name, now, log);
    const RoomSearch search = judge_room(walls, shape, params_.rooms, params_.topology.judge_slack);
    const auto twin =
        std::find_if(rooms_.begin(), room, [&](const auto& other) { return shared_share(other.second.shape.area, shape.area) > same_place; });
    if (search.room) {
      shape = turned_to(*search.room, shape.area.yaw);
      room->second.history.failures = 0;
    } else {
      ++room->second.history.failures;
    }
    if (twin != room) {
      log.push_back({now, false, name, "withdrawn: it is room/" + std::to_string(twin->first.value)});
      room = rooms_.erase(room);
    } else if (room->second.history.failures >= params_.topology.withdraw_after) {
      log.push_back({now, false, name, std::string("withdrawn: ") + to_string(search.verdict)});
      room = rooms_.erase(room);
    } else {
      ++room;
    }
  }
}

void TopologicalLayer::judge_corridors(const std::vector<Wall>& walls, const std::set<PlaneId>* touched, KeyframeId now, DecisionLog& log) {
  for (auto corridor = corridors_.begin(); corridor != corridors_.end();) {
    CorridorShape& shape = corridor->second.shape;
    const auto concerned = [&](PlaneId id) { return touched->count(id) > 0; };
    if (touched && std::none_of(shape.walls.begin(), shape.walls.end(), concerned)) {
      ++corridor;
      continue;
    }
    const std::string name = "corridor/" + std::to_string(corridor->first.value);
    prefer_dominant_walls(walls, shape, params_.corridors, name, now, log);
    const CorridorSearch search = judge_corridor(walls, shape, params_.corridors, params_.topology.judge_slack);
    if (search.corridor) {
      shape = *search.corridor;
      corridor->second.history.failures = 0;
    } else {
      ++corridor->second.history.failures;
    }
    const auto twin = std::find_if(corridors_.begin(), corridor, [&](const auto& other) {
      return shared_share(other.second.shape.area, shape.area) > same_place || same_corridor(other.second.shape, shape, params_.corridors);
    });
    const auto room =
        std::find_if(rooms_.begin(), rooms_.end(), [&](const auto& other) { return shared_share(other.second.shape.area, shape.area) > same_place; });
    std::string reason;
    if (twin != corridor) {
      reason = "it is corridor/" + std::to_string(twin->first.value);
      if (shape.area.size.x() > twin->second.shape.area.size.x()) twin->second.shape = shape;
    }
    if (room != rooms_.end()) reason = "its walls are those of room/" + std::to_string(room->first.value);
    if (corridor->second.history.failures >= params_.topology.withdraw_after) reason = to_string(search.verdict);
    if (reason.empty()) {
      ++corridor;
    } else {
      log.push_back({now, false, name, "withdrawn: " + reason});
      corridor = corridors_.erase(corridor);
    }
  }
}

void TopologicalLayer::judge(const Graph& graph, const std::vector<Wall>& walls, const std::set<PlaneId>* touched, KeyframeId now, DecisionLog& log) {
  follow_merges(graph);
  judge_rooms(walls, touched, now, log);
  judge_corridors(walls, touched, now, log);
}

bool TopologicalLayer::covers(const Eigen::Vector2d& position) const {
  const auto inside = [&](const auto& entry) { return entry.second.shape.area.contains(position); };
  return std::any_of(rooms_.begin(), rooms_.end(), inside) || std::any_of(corridors_.begin(), corridors_.end(), inside);
}

std::vector<Place> TopologicalLayer::places() const {
  std::vector<Place> places;
  for (const auto& [id, room] : rooms_) places.push_back({"room/" + std::to_string(id.value), room.shape.area});
  for (const auto& [id, corridor] : corridors_) places.push_back({"corridor/" + std::to_string(id.value), corridor.shape.area});
  return places;
}

}  // namespace sgraph
