#include "doors.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

constexpr double before_face = 0.15;  // a place has this point before its face inside [m]
constexpr double deepest = 0.9;       // the place behind a wall begins no further behind its face [m]
constexpr double same_door = 0.6;     // gaps of the two faces of a wall [m]
constexpr double raster_loss = 0.1;   // both jambs' cells count as wall: the raster shows a door narrower by this, for cells of 5 cm [m]
constexpr double jamb_search = 0.2;   // around the raster's jamb [m]
constexpr double from_faces = 0.03;   // what is nearer to a face of the wall is the face, not the jamb [m]
constexpr double thinnest = 0.1;      // a wall of less than this has no jamb that could be told from its faces [m]
constexpr std::size_t least_points = 6;
constexpr double usual_thickness = 0.15;  // of a wall of which one face is known [m]
constexpr double lowest_lintel = 1.85;
constexpr double highest_lintel = 3.5;

// The places that hold a point, as a set of bits would be too small.
std::vector<std::size_t> places_at(const FoundPlaces& all, const Eigen::Vector2d& p) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < all.places.size(); ++i) {
    if (contains(all.places[i].outline, p)) found.push_back(i);
  }
  if (!found.empty()) return found;
  // Between the corridors of a branching: the nearest.
  for (const FoundBranching& branching : all.branchings) {
    if (!contains(branching.outline, p)) continue;
    const auto distance = [&](std::size_t i) { return distance_to_outline(all.places[i].outline.polygon, p); };
    return {
        *std::min_element(branching.parts.begin(), branching.parts.end(), [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); })};
  }
  return found;
}

bool is_one_place(const FoundPlaces& all, std::size_t a, std::size_t b) {
  const auto has = [](const std::vector<std::size_t>& parts, std::size_t i) { return std::count(parts.begin(), parts.end(), i) > 0; };
  return a == b || std::any_of(all.branchings.begin(), all.branchings.end(),
                               [&](const FoundBranching& branching) { return has(branching.parts, a) && has(branching.parts, b); });
}

struct Behind {
  std::vector<std::size_t> places;
  double depth = 0;  // of the wall, about
};

// What lies behind a gap, as far as no other face closes it.
Behind behind(const FoundPlaces& places, const std::vector<WallLine>& lines, const WallLine& line, double along) {
  const double end = std::min(deepest, way_to_face(lines, line.at(along), -line.normal));
  for (double depth = 0.05; depth <= end; depth += 0.05) {
    std::vector<std::size_t> found = places_at(places, line.at(along) - (depth + 0.05) * line.normal);
    if (!found.empty()) return {std::move(found), depth};
  }
  return {};
}

}  // namespace

std::vector<FoundDoor> find_doors(const std::vector<WallLine>& lines, const FoundPlaces& places, const PlaceParams& params) {
  std::vector<FoundDoor> doors;
  for (const WallLine& line : lines) {
    if (line.faces.empty()) continue;  // where a corridor ends, not a wall
    for (const Gap& gap : line.gaps) {
      if (!gap.low_jamb || !gap.high_jamb || gap.along.length() > params.widest_door) continue;
      const double middle = gap.along.center();
      const std::vector<std::size_t> front = places_at(places, line.at(middle) + before_face * line.normal);
      Behind back = behind(places, lines, line, middle);
      if (front.empty()) continue;
      if (back.places.empty()) {
        // The wall's other face has not been seen from here; its thickness is a usual one.
        if (!gap.cut || gap.along.length() > params.max_door) continue;
        back = {{FoundDoor::nowhere}, usual_thickness};
      }
      const bool within_one = std::any_of(front.begin(), front.end(), [&](std::size_t i) {
        return std::any_of(back.places.begin(), back.places.end(),
                           [&](std::size_t k) { return k != FoundDoor::nowhere && is_one_place(places, i, k); });
      });
      if (within_one) continue;
      FoundDoor door;
      const bool forth = front.front() < back.places.front();
      door.places = {std::min(front.front(), back.places.front()), std::max(front.front(), back.places.front())};
      const Eigen::Vector2d way = forth ? (-line.normal).eval() : line.normal;
      door.yaw = std::atan2(way.y(), way.x());
      door.position = line.at(middle) - 0.5 * back.depth * line.normal;
      door.width = gap.along.length() + raster_loss;
      door.depth = back.depth;
      const auto known = std::find_if(doors.begin(), doors.end(), [&](const FoundDoor& other) {
        return other.places == door.places && (other.position - door.position).norm() < same_door;
      });
      if (known == doors.end()) {
        doors.push_back(door);
      } else {
        known->position = 0.5 * (known->position + door.position);
        known->width = 0.5 * (known->width + door.width);
      }
    }
  }
  return doors;
}

void measure_door(const FreeSpace& space, FoundDoor& door) {
  const Eigen::Vector2d way(std::cos(door.yaw), std::sin(door.yaw));
  const Eigen::Vector2d along(-way.y(), way.x());
  std::vector<double> low;
  std::vector<double> high;
  std::vector<double> lintel;
  const double half = 0.5 * door.width;
  const double deep = std::max(0.5 * door.depth - from_faces, 0.02);
  for (const Eigen::Vector3d& end : space.ends_near(door.position, 6, half + 0.5)) {
    const double z = end.z() - space.floor_z();
    const double s = along.dot(end.head<2>() - door.position);
    const double t = way.dot(end.head<2>() - door.position);
    if (z > 0.1 && z < lowest_lintel && std::abs(t) < deep) {
      if (std::abs(s + half) < jamb_search) low.push_back(s);
      if (std::abs(s - half) < jamb_search) high.push_back(s);
    }
    if (z > lowest_lintel && z < highest_lintel && std::abs(t) < 0.5 * door.depth + from_faces && std::abs(s) < half - 0.1) lintel.push_back(z);
  }
  if (low.size() >= least_points && high.size() >= least_points) {
    // A pane has no jambs, its points lie along it: it ends where they do, but for a few strays.
    const bool thin = door.depth < thinnest;
    std::sort(low.begin(), low.end());
    std::sort(high.begin(), high.end());
    const double a = thin ? low[low.size() - 1 - low.size() / 20] : upper_median(low);
    const double b = thin ? high[high.size() / 20] : upper_median(high);
    door.position += 0.5 * (a + b) * along;
    door.width = b - a;
  }
  if (lintel.size() >= least_points) {
    std::sort(lintel.begin(), lintel.end());
    door.height = lintel[lintel.size() / 20];
  }
}

}  // namespace sgraph
