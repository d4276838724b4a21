#include "sgraph_slam/core/places/find_places.hpp"

#include <algorithm>
#include <utility>

#include "corridor_pieces.hpp"
#include "doors.hpp"
#include "four_walls.hpp"
#include "sgraph_slam/core/places/islands.hpp"

namespace sgraph {
namespace {

constexpr double sample = 0.1;  // [m]
constexpr double wider = 1.25;  // a hall is wider than the corridors that open into it by this factor

// Four walls and nothing else: no piece of a corridor is looked for.
bool has_four_sides(const PlaceOutline& outline) { return outline.polygon.size() == 4 && outline.holes.empty() && four_walls(outline); }

// Share of a region's cells that lie in one of the rectangles.
double share_in(const FreeSpace& space, const Regions& regions, int region, const std::vector<FoundPlace>& places) {
  double all = 0;
  double inside = 0;
  const CellWindow& extent = regions.extent[static_cast<std::size_t>(region)];
  for (int y = extent.y; y < extent.y + extent.height; y += 2) {
    for (int x = extent.x; x < extent.x + extent.width; x += 2) {
      if (regions.at(x, y) != region) continue;
      const Eigen::Vector2d p = space.origin() + space.resolution() * Eigen::Vector2d(x + 0.5, y + 0.5);
      ++all;
      if (std::any_of(places.begin(), places.end(), [&](const FoundPlace& place) { return place.area.contains(p, -0.05); })) ++inside;
    }
  }
  return all > 0 ? inside / all : 1;
}

// The corridors whose middle line runs mostly in a region.
std::vector<std::size_t> corridors_in(const FreeSpace& space, const Regions& regions, int region, const std::vector<FoundPlace>& corridors) {
  std::vector<std::size_t> parts;
  for (std::size_t i = 0; i < corridors.size(); ++i) {
    const OrientedRectangle& area = corridors[i].area;
    const Eigen::Vector2d axis(std::cos(area.yaw), std::sin(area.yaw));
    int known = 0;
    int own = 0;
    for (double s = -0.5 * area.size.x() + sample; s < 0.5 * area.size.x(); s += sample) {
      const Eigen::Vector2d c = ((area.center + s * axis - space.origin()) / space.resolution()).array().floor();
      const int label = regions.at(static_cast<int>(c.x()), static_cast<int>(c.y()));
      known += label >= 0 ? 1 : 0;
      own += label == region ? 1 : 0;
    }
    if (2 * own > known) parts.push_back(i);
  }
  return parts;
}

// What the corridors leave that is large enough to be a hall: wider than a corridor both ways. The rest are corners of their crossings and bends.
std::vector<char> halls_in(const FreeSpace& space, const Regions& regions, const std::vector<FoundPlace>& corridors) {
  double width = 0;
  for (const FoundPlace& corridor : corridors) width += corridor.area.size.y() / static_cast<double>(corridors.size());
  const double cell = space.resolution();
  std::vector<double> size(static_cast<std::size_t>(regions.count), 0);
  for (const std::int32_t label : regions.label) {
    if (label >= 0) size[static_cast<std::size_t>(label)] += cell * cell;
  }
  std::vector<char> halls(size.size(), 0);
  for (std::size_t i = 0; i < halls.size(); ++i) {
    const double least = cell * std::min(regions.extent[i].width, regions.extent[i].height);
    halls[i] = least > wider * width && size[i] > width * width && share_in(space, regions, static_cast<int>(i), corridors) <= 0.5;
  }
  return halls;
}

// Of the cuts behind the first `walls` lines those stretches that have a hall beside them.
void keep_cuts_at_halls(const FreeSpace& space, const Regions& regions, const std::vector<char>& halls, std::size_t walls,
                        std::vector<WallLine>& lines) {
  const auto is_hall = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d c = ((p - space.origin()) / space.resolution()).array().floor();
    const int label = regions.at(static_cast<int>(c.x()), static_cast<int>(c.y()));
    return label >= 0 && halls[static_cast<std::size_t>(label)];
  };
  for (std::size_t k = walls; k < lines.size(); ++k) {
    WallLine& line = lines[k];
    std::vector<Gap> kept;
    for (const Gap& gap : line.gaps) {
      Intervals beside;
      for (double s = gap.along.low; s < gap.along.high; s += 0.5 * sample) {
        const double end = std::min(s + 0.5 * sample, gap.along.high);
        bool hall = false;
        for (const double depth : {-0.2, -0.15, -0.1, 0.1, 0.15, 0.2}) hall = hall || is_hall(line.at(0.5 * (s + end)) + depth * line.normal);
        if (hall) beside.push_back({s, end});
      }
      for (const Interval& stretch : unite(std::move(beside), sample)) {
        kept.push_back(gap);
        kept.back().along = stretch;
      }
    }
    line.gaps = std::move(kept);
  }
  const auto nothing = [](const WallLine& line) { return line.gaps.empty() && line.faces.empty(); };
  lines.erase(std::remove_if(lines.begin() + static_cast<std::ptrdiff_t>(walls), lines.end(), nothing), lines.end());
}

void add_place(const PlaceOutline& outline, const std::vector<Wall>& walls, double reference_yaw, const PlaceParams& params,
               std::vector<FoundPlace>& places) {
  if (area(outline) < params.min_area) return;
  if (const auto four = four_walls(outline)) {
    places.push_back(room_or_corridor(outline, *four, walls, reference_yaw, params));
    return;
  }
  FoundPlace place;
  place.outline = outline;
  place.area = rectangle_around(outline.polygon);
  places.push_back(std::move(place));
}

}  // namespace

FoundPlaces find_places(const FreeSpace& space, const std::vector<Wall>& walls, const std::vector<Eigen::Vector2d>& path, double reference_yaw,
                        const PlaceParams& params) {
  FoundPlaces found;
  std::vector<WallLine> lines = find_wall_lines(walls, space, path, params);
  join_over_low_lines(space, params, lines);
  Regions regions = find_regions(space, lines, path, params);
  if (join_recesses(space, regions, lines)) regions = find_regions(space, lines, path, params, std::move(regions));
  if (drop_islands(space, regions, lines)) regions = find_regions(space, lines, path, params, std::move(regions));
  std::vector<FoundPlace> corridors;
  std::vector<CorridorPiece> pieces_of_corridors;
  std::vector<int> composite;
  for (int region = 0; region < regions.count; ++region) {
    if (!regions.entered[static_cast<std::size_t>(region)]) continue;
    const auto outline = find_outline(space, regions, region, lines, walls, params);
    if (!outline) continue;
    std::vector<CorridorPiece> pieces;
    if (!has_four_sides(*outline)) pieces = corridor_pieces(*outline, params);
    if (pieces.empty()) {
      add_place(*outline, walls, reference_yaw, params, found.places);
      continue;
    }
    composite.push_back(region);
    for (const CorridorPiece& piece : pieces) {
      auto corridor = corridor_place(piece, *outline, walls, reference_yaw);
      if (!corridor) continue;
      corridors.push_back(std::move(*corridor));
      pieces_of_corridors.push_back(piece);
    }
  }
  const std::size_t walls_only = lines.size();
  for (std::size_t i = 0; i < pieces_of_corridors.size(); ++i) {
    std::vector<OrientedRectangle> others;
    for (std::size_t k = 0; k < pieces_of_corridors.size(); ++k) {
      if (k != i) others.push_back(rectangle_of(pieces_of_corridors[k]));
    }
    add_cuts(pieces_of_corridors[i], others, lines);
  }
  if (!composite.empty()) {
    // What the corridors leave of the regions that they are part of.
    Regions rest = find_regions(space, lines, path, params);
    keep_cuts_at_halls(space, rest, halls_in(space, rest, corridors), walls_only, lines);
    rest = find_regions(space, lines, path, params, std::move(rest));
    for (int region = 0; region < rest.count; ++region) {
      if (!rest.entered[static_cast<std::size_t>(region)]) continue;
      bool of_composite = false;
      const CellWindow& extent = rest.extent[static_cast<std::size_t>(region)];
      for (int y = extent.y; y < extent.y + extent.height && !of_composite; ++y) {
        for (int x = extent.x; x < extent.x + extent.width && !of_composite; ++x)
          of_composite = rest.at(x, y) == region && std::find(composite.begin(), composite.end(), regions.at(x, y)) != composite.end();
      }
      if (!of_composite) continue;
      const bool corridor = share_in(space, rest, region, corridors) > 0.5;
      const std::vector<std::size_t> parts = corridor ? corridors_in(space, rest, region, corridors) : std::vector<std::size_t>{};
      if (corridor && parts.empty()) continue;
      auto outline = find_outline(space, rest, region, lines, walls, params);
      if (!outline) continue;
      // A corridor alone is its rectangle, unless its floor is more than that: niches, a wider end.
      if (parts.size() == 1 && area(*outline) < wider * corridors[parts[0]].area.area()) continue;
      if (corridor) {
        found.branchings.push_back({std::move(*outline), parts});
      } else {
        add_place(*outline, walls, reference_yaw, params, found.places);
      }
    }
    for (FoundBranching& branching : found.branchings) {
      for (std::size_t& part : branching.parts) part += found.places.size();
    }
    for (FoundPlace& corridor : corridors) found.places.push_back(std::move(corridor));
  }
  found.doors = find_doors(lines, found, params);
  return found;
}

}  // namespace sgraph
