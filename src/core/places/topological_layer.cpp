#include "sgraph_slam/core/places/topological_layer.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <sstream>
#include <utility>

#include <Eigen/Geometry>

namespace sgraph {
namespace {

constexpr double same_place = 0.5;   // share of the smaller area: more in common and it is the same place
constexpr double grid = 0.2;         // on which common areas are counted [m]
constexpr double grown = 0.1;        // change of a place's area that is told of
constexpr double same_door = 0.6;    // [m]
constexpr double moved_door = 0.05;  // change of a known door's width by which it is measured anew [m]
constexpr double along_side = 0.5;   // a plane along a side shares at least this much of it [m]

std::string size_text(const FoundPlace& place) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2);
  if (place.kind == PlaceKind::hall) {
    text << area(place.outline) << " m^2 with " << place.outline.polygon.size() << " sides";
  } else {
    text << place.area.size.x() << " m x " << place.area.size.y() << " m";
  }
  const Eigen::Vector2d at = place.kind == PlaceKind::hall ? centroid(place.outline.polygon) : place.area.center;
  text << " at (" << at.x() << ", " << at.y() << ")";
  return text.str();
}

std::string planes_text(const FoundPlace& place) {
  std::string text;
  for (const PlaceSide& side : place.outline.sides) {
    if (side.plane.valid()) text += (text.empty() ? "planes " : ", ") + std::to_string(side.plane.value);
  }
  return text;
}

const char* kind_text(PlaceKind kind) {
  switch (kind) {
    case PlaceKind::room: return "room between four walls";
    case PlaceKind::corridor: return "corridor between two walls";
    case PlaceKind::hall: break;
  }
  return "hall";
}

// A place's floor on a grid: by row, the stretches of its cells [first, end).
using Footprint = std::map<int, std::vector<std::pair<int, int>>>;

Footprint footprint_of(const PlaceOutline& outline) {
  std::map<int, std::vector<double>> crossings;  // by row, with all loops: a hole takes out what lies within it
  const auto add = [&](const Polygon2d& polygon) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Eigen::Vector2d& a = polygon[i];
      const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
      const double low = std::min(a.y(), b.y()) / grid - 0.5;
      const double high = std::max(a.y(), b.y()) / grid - 0.5;
      for (int row = static_cast<int>(std::floor(low)) + 1; row <= static_cast<int>(std::floor(high)); ++row)
        crossings[row].push_back(a.x() + ((row + 0.5) * grid - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    }
  };
  add(outline.polygon);
  for (const PlaceLoop& hole : outline.holes) add(hole.polygon);
  Footprint footprint;
  for (auto& [row, at] : crossings) {
    std::sort(at.begin(), at.end());
    const auto first_from = [](double x) { return static_cast<int>(std::ceil(x / grid - 0.5)); };
    for (std::size_t i = 0; i + 1 < at.size(); i += 2) footprint[row].emplace_back(first_from(at[i]), first_from(at[i + 1]));
  }
  return footprint;
}

double common_area(const Footprint& a, const Footprint& b) {
  int cells = 0;
  for (const auto& [row, own] : a) {
    const auto other = b.find(row);
    if (other == b.end()) continue;
    for (const auto& [first, end] : own) {
      for (const auto& [from, to] : other->second) cells += std::max(0, std::min(end, to) - std::max(first, from));
    }
  }
  return cells * grid * grid;
}

PlanePair older_first(PlaneId a, PlaneId b) { return a < b ? PlanePair{a, b} : PlanePair{b, a}; }

// Pairs along the sides of a place.
void add_pairs(const FoundPlace& place, const std::vector<Wall>& walls, KeyframeId now, int recent, const MergeParams& params,
               std::vector<PlanePair>& pairs) {
  const Polygon2d& polygon = place.outline.polygon;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PlaneId own = place.outline.sides[i].plane;
    const auto face = std::find_if(walls.begin(), walls.end(), [&](const Wall& wall) { return wall.id == own; });
    if (!own.valid() || face == walls.end()) continue;
    const double a = face->direction().dot(polygon[i]);
    const double b = face->direction().dot(polygon[(i + 1) % polygon.size()]);
    const Interval side{std::min(a, b), std::max(a, b)};
    for (const Wall& wall : walls) {
      if (wall.id == own || wall.last_seen.value <= now.value - recent || wall.normal.dot(face->normal) < std::cos(params.max_angle)) continue;
      const Interval stretch = hull(wall.support);
      const double c = face->direction().dot(wall.at(stretch.low));
      const double d = face->direction().dot(wall.at(stretch.high));
      if (overlap(side, {std::min(c, d), std::max(c, d)}) < along_side || std::abs(face->distance(wall.at(stretch.center()))) > params.max_distance)
        continue;
      pairs.push_back(older_first(own, wall.id));
    }
  }
}

}  // namespace

StoreyHeights find_storey(const Graph& graph, const PlaneMap& planes) { return find_storey(graph, planes, graph.keyframes(), 0); }

StoreyHeights find_storey(const Graph& graph, const PlaneMap& planes, const std::map<KeyframeId, Pose>& keyframes, int number) {
  StoreyHeights storey;
  double base = 0;
  for (const auto& [id, pose] : keyframes) base += pose.translation.z() / static_cast<double>(keyframes.size());
  double largest_floor = 0;
  double largest_ceiling = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& [id, record] : planes.records()) {
    const Plane* plane = graph.find(id);
    if (plane == nullptr || record.outline.empty() || record.storey != number) continue;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& corner : record.outline) box.extend(corner);
    if (record.plane_class != PlaneClass::horizontal) {
      lowest = std::min(lowest, box.min().z());
      continue;
    }
    const double z = box.center().z();
    const double area = box.sizes().x() * box.sizes().y();
    if (plane->normal.z() > 0 && z < base + 0.1 && area > largest_floor) {
      largest_floor = area;
      storey.floor = z;
    }
    if (plane->normal.z() < 0 && z > base && area > largest_ceiling) {
      largest_ceiling = area;
      storey.ceiling = z;
      storey.ceiling_seen = true;
    }
  }
  if (largest_floor == 0) storey.floor = std::isfinite(lowest) ? std::min(lowest, base) : base;
  if (!storey.ceiling_seen) storey.ceiling = storey.floor;
  return storey;
}

std::string TopologicalLayer::name_of(const Known& known) { return (known.corridor ? "corridor/" : "room/") + std::to_string(known.id); }

std::vector<PlanePair> TopologicalLayer::shown_at(const std::vector<Wall>& walls, const Eigen::Vector2d& position, KeyframeId now, int storey) const {
  std::vector<PlanePair> pairs;
  const auto look = [&](const auto& records) {
    for (const auto& [id, record] : records) {
      if (record.storey == storey && contains(record.place.outline, position))
        add_pairs(record.place, walls, now, params_.topology.recent, params_.merging, pairs);
    }
  };
  look(rooms_);
  look(corridors_);
  return pairs;
}

std::vector<std::string> TopologicalLayer::give_names(Graph& graph, std::vector<FoundPlace> found, const std::vector<int>& storeys, KeyframeId now,
                                                      DecisionLog& log) {
  std::vector<Known> known;
  for (const auto& [id, record] : rooms_) known.push_back({false, id.value, record, false});
  for (const auto& [id, record] : corridors_) known.push_back({true, id.value, record, false});
  for (const Known& lost : lost_) known.push_back(lost);
  // Which of the known is which of the found: those that share most first, those not lost before lost ones, older before younger.
  struct Match {
    double common;
    std::size_t known, found;
  };
  std::vector<Match> matches;
  std::vector<Footprint> footprints;
  for (const FoundPlace& place : found) footprints.push_back(footprint_of(place.outline));
  for (std::size_t k = 0; k < known.size(); ++k) {
    const Footprint own = footprint_of(known[k].record.place.outline);
    const double size = area(known[k].record.place.outline);
    for (std::size_t f = 0; f < found.size(); ++f) {
      if (known[k].record.storey != storeys[f]) continue;
      const double common = common_area(own, footprints[f]);
      if (common > same_place * std::min(size, area(found[f].outline))) matches.push_back({common, k, f});
    }
  }
  std::stable_sort(matches.begin(), matches.end(), [&](const Match& a, const Match& b) {
    if (known[a.known].lost != known[b.known].lost) return known[b.known].lost;
    return a.common > b.common + 1e-9;
  });
  const std::size_t none = known.size();
  std::vector<std::size_t> known_of(found.size(), none);
  std::vector<std::size_t> found_of(known.size(), found.size());
  for (const Match& match : matches) {
    if (known_of[match.found] != none || found_of[match.known] != found.size()) continue;
    known_of[match.found] = match.known;
    found_of[match.known] = match.found;
  }
  rooms_.clear();
  corridors_.clear();
  lost_.clear();
  std::vector<std::string> names(found.size());
  for (std::size_t f = 0; f < found.size(); ++f) {
    const bool corridor = found[f].kind == PlaceKind::corridor;
    const std::size_t k = known_of[f];
    const bool keeps = k != none && known[k].corridor == corridor;
    const std::int64_t id = keeps ? known[k].id : corridor ? graph.new_corridor_id().value : graph.new_room_id().value;
    PlaceRecord record{std::move(found[f]), keeps ? known[k].record.since : now, storeys[f]};
    names[f] = name_of({corridor, id, {}, false});
    std::string reason;
    if (!keeps) {
      reason = std::string(kind_text(record.place.kind)) + " (" + planes_text(record.place) + "), " + size_text(record.place);
      if (k != none) reason = "was " + name_of(known[k]) + ": " + reason;
      if (k == none) {
        const auto parent = std::find_if(matches.begin(), matches.end(), [&](const Match& m) { return m.found == f; });
        if (parent != matches.end()) reason = "split from " + name_of(known[parent->known]) + ": " + reason;
      }
    } else {
      const double before = area(known[k].record.place.outline);
      const double after = area(record.place.outline);
      if (known[k].lost) {
        reason = "found again: " + size_text(record.place);
      } else if (std::abs(after - before) > grown * before || known[k].record.place.kind != record.place.kind) {
        reason = std::string(after > before ? "grew" : "shrank") + " from " + size_text(known[k].record.place) + " to " + size_text(record.place);
      }
    }
    if (!reason.empty()) log.push_back({now, true, names[f], reason});
    if (corridor) {
      corridors_[{id}] = std::move(record);
    } else {
      rooms_[{id}] = std::move(record);
    }
  }
  for (std::size_t k = 0; k < known.size(); ++k) {
    if (found_of[k] != found.size()) continue;
    const auto into = std::find_if(matches.begin(), matches.end(), [&](const Match& m) { return m.known == k; });
    if (!known[k].lost) {
      const std::string reason = into != matches.end() ? "joined " + names[into->found] : "withdrawn: no walls and free floor make it any more";
      log.push_back({now, false, name_of(known[k]), reason});
    }
    known[k].lost = true;
    lost_.push_back(known[k]);
  }
  return names;
}

void TopologicalLayer::keep_branchings(const std::vector<FoundBranching>& found, const std::vector<std::string>& names,
                                       const std::vector<int>& storeys, KeyframeId now, DecisionLog& log) {
  std::vector<BranchingRecord> branchings;
  for (const FoundBranching& one : found) {
    BranchingRecord record{one.outline, {}, storeys[one.parts.front()]};
    for (const std::size_t part : one.parts) record.parts.push_back({std::stoll(names[part].substr(names[part].find('/') + 1))});
    std::sort(record.parts.begin(), record.parts.end());
    branchings.push_back(std::move(record));
  }
  std::sort(branchings.begin(), branchings.end(), [](const BranchingRecord& a, const BranchingRecord& b) { return a.parts < b.parts; });
  for (const BranchingRecord& record : branchings) {
    const auto same = [&](const BranchingRecord& before) { return before.parts == record.parts; };
    if (std::any_of(branchings_.begin(), branchings_.end(), same)) continue;
    std::string others;
    for (std::size_t i = 1; i < record.parts.size(); ++i) others += (i > 1 ? ", corridor/" : "corridor/") + std::to_string(record.parts[i].value);
    log.push_back({now, true, "corridor/" + std::to_string(record.parts[0].value),
                   others.empty() ? "its floor is more than what lies between its two walls" : "one piece of floor with " + others});
  }
  branchings_ = std::move(branchings);
}

void TopologicalLayer::give_names_to_doors(const std::vector<FoundDoor>& found, const std::vector<std::string>& names,
                                           const std::vector<int>& storeys, bool measure_all, KeyframeId now, DecisionLog& log) {
  std::map<DoorId, DoorRecord> doors;
  for (const FoundDoor& seen : found) {
    const std::string to = seen.places[1] == FoundDoor::nowhere ? "" : names[seen.places[1]];
    DoorRecord record{seen, names[seen.places[0]], to, storeys[seen.places[0]]};
    const auto known = std::find_if(doors_.begin(), doors_.end(), [&](const auto& entry) {
      return doors.count(entry.first) == 0 && entry.second.storey == record.storey && (entry.second.door.position - seen.position).norm() < same_door;
    });
    const bool same = known != doors_.end() && std::abs(known->second.door.width - seen.width) < moved_door && !measure_all;
    if (same) {
      record.door.width = known->second.door.width;
      record.door.height = known->second.door.height;
    } else {
      measure_door(space_of(record.storey), record.door);
    }
    const DoorId id = known != doors_.end() ? known->first : DoorId{next_door_++};
    if (known == doors_.end()) {
      std::ostringstream reason;
      reason << std::fixed << std::setprecision(2) << "gap of " << record.door.width << " m between " << record.from << " and "
             << (record.to.empty() ? "where the robot has not been" : record.to);
      log.push_back({now, true, "door/" + std::to_string(id.value), reason.str()});
    }
    doors[id] = std::move(record);
  }
  for (const auto& [id, record] : doors_) {
    if (doors.count(id) == 0) log.push_back({now, false, "door/" + std::to_string(id.value), "withdrawn: no gap between two places any more"});
  }
  doors_ = std::move(doors);
}

void TopologicalLayer::find(Graph& graph, const std::vector<Survey>& surveys, DecisionLog& log) {
  FoundPlaces all;
  std::vector<int> storeys;
  storeys_.clear();
  for (const Survey& survey : surveys) {
    storeys_[survey.number] = survey.storey;
    FreeSpace& space = space_of(survey.number);
    space.update(survey.keyframes ? *survey.keyframes : graph.keyframes(), survey.storey.floor);
    take(find_places(space, survey.walls, survey.path, survey.building_yaw, params_.places), all);
    storeys.resize(all.places.size(), survey.number);
  }
  const std::vector<std::string> names = give_names(graph, std::move(all.places), storeys, surveys.front().now, log);
  keep_branchings(all.branchings, names, storeys, surveys.front().now, log);
  give_names_to_doors(all.doors, names, storeys, surveys.front().measure_all_doors, surveys.front().now, log);
}

// Appends the places that are wanted, and what they share: doors and branchings.
void TopologicalLayer::take(FoundPlaces found, FoundPlaces& all) const {
  const std::size_t none = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> number(found.places.size(), none);
  for (std::size_t i = 0; i < found.places.size(); ++i) {
    const bool wanted = found.places[i].kind == PlaceKind::corridor ? params_.topology.corridors : params_.topology.rooms;
    if (!wanted) continue;
    number[i] = all.places.size();
    all.places.push_back(std::move(found.places[i]));
  }
  for (FoundDoor door : found.doors) {
    const auto wanted = [&](std::size_t place) { return place == FoundDoor::nowhere || number[place] != none; };
    if (!wanted(door.places[0]) || !wanted(door.places[1])) continue;
    for (std::size_t& place : door.places) place = place == FoundDoor::nowhere ? place : number[place];
    all.doors.push_back(door);
  }
  if (!params_.topology.corridors) return;
  for (FoundBranching branching : found.branchings) {
    for (std::size_t& part : branching.parts) part = number[part];
    all.branchings.push_back(std::move(branching));
  }
}

bool TopologicalLayer::is_bounded_by(const Graph& graph) const {
  const auto is_there = [&graph](PlaneId id) { return !id.valid() || graph.find(graph.representative(id)) != nullptr; };
  const auto is_whole = [&](const auto& entry) {
    const FoundPlace& place = entry.second.place;
    return std::all_of(place.walls.begin(), place.walls.end(), is_there) &&
           std::all_of(place.outline.sides.begin(), place.outline.sides.end(), [&](const PlaceSide& side) { return is_there(side.plane); });
  };
  return std::all_of(rooms_.begin(), rooms_.end(), is_whole) && std::all_of(corridors_.begin(), corridors_.end(), is_whole);
}

bool TopologicalLayer::covers(const Eigen::Vector2d& position) const {
  const auto inside = [&](const auto& entry) { return contains(entry.second.place.outline, position); };
  return std::any_of(rooms_.begin(), rooms_.end(), inside) || std::any_of(corridors_.begin(), corridors_.end(), inside) ||
         std::any_of(branchings_.begin(), branchings_.end(), [&](const BranchingRecord& record) { return contains(record.outline, position); });
}

std::vector<Place> TopologicalLayer::places(int storey) const {
  std::vector<Place> places;
  const auto add = [&](const char* kind, const auto& records) {
    for (const auto& [id, record] : records) {
      if (record.storey == storey) places.push_back({kind + std::to_string(id.value), record.place.outline.polygon});
    }
  };
  add("room/", rooms_);
  add("corridor/", corridors_);
  return places;
}

}  // namespace sgraph
