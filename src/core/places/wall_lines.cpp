#include "sgraph_slam/core/places/wall_lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sgraph {
namespace {

constexpr double step = 0.05;                 // along a line [m]
constexpr double beyond = 1.8;                // a door may lie between a wall's end and the next wall: this far the line is followed [m]
constexpr double parallel = 0.07;             // between faces of one line [rad]
constexpr double swing = 1.5;                 // the ends of a face of a line may be off by this much more than its middle
constexpr double nearest = 0.6;               // faces this near along the line may be one wall however short they are [m]
constexpr double near = 3.0;                  // faces further apart along the line are no one wall [m]
constexpr double shortest_face = 0.35;        // [m]
constexpr double scrap = 0.6;                 // [m]
constexpr double loose = 0.15;                // a speck in a gap may be this long [m]
constexpr int least_hits = 2;                 // keyframes that saw a pane where most saw through
constexpr double least_share = 0.03;          // who walks by a metre before a pane meets it squarely from one keyframe of thirty
constexpr double more_than_stray = 3;         // times the hits a ray of the open floor
constexpr double pane = 0.4;                  // a pane is looked for this far to both sides [m]
constexpr double most_of_section = 0.6;       // share of the narrower place's width
constexpr double furthest = 40;               // a place is wide enough for any gap [m]
constexpr double facing_least = 0.2;          // a way that grazes a face by less than this (sine) goes on
constexpr double jamb_reach = 0.12;           // between a gap and the wall that ends it: two cells and noise [m]
constexpr double cross_section_margin = 0.2;  // a door is narrower than the places by at least this [m]

double weight(const Wall& wall) { return total_length(wall.support) * trust(wall); }

Interval along_line(const Wall& wall, Interval part, const Eigen::Vector2d& direction) {
  const double a = direction.dot(wall.at(part.low));
  const double b = direction.dot(wall.at(part.high));
  return {std::min(a, b), std::max(a, b)};
}

bool fits(const WallLine& line, const Wall& wall, double coplanar) {
  if (line.normal.dot(wall.normal) < std::cos(parallel)) return false;
  const Interval own = hull(wall.support);
  const Interval stretch = along_line(wall, own, line.direction());
  // A short face (a cupboard's side) far off in the same direction is no part of this wall.
  const double apart = std::clamp(std::min(own.length(), hull(line.support).length()), nearest, near);
  if (overlap(stretch, hull(line.support)) < -apart) return false;
  // A face's place is known better than its direction: its ends swing.
  const auto within = [&](double along, double most) { return std::abs(line.distance(wall.at(along))) <= most; };
  return within(own.center(), coplanar) && within(own.low, swing * coplanar) && within(own.high, swing * coplanar);
}

void add_face(WallLine& line, const Wall& wall, std::size_t index) {
  line.faces.push_back(index);
  Intervals parts = line.support;
  for (const Interval& part : wall.support) parts.push_back(along_line(wall, part, line.direction()));
  line.support = unite(std::move(parts));
}

// What stands before a longer face and hides it.
bool is_furniture(const WallLine& line, const WallLine& behind, const PlaceParams& params) {
  if (line.normal.dot(behind.normal) < std::cos(0.12)) return false;
  const Interval own = hull(line.support);
  const double depth = behind.distance(line.at(own.center()));
  if (depth <= params.coplanar || depth > params.furniture_depth) return false;
  const double a = behind.direction().dot(line.at(own.low));
  const double b = behind.direction().dot(line.at(own.high));
  Interval whole = hull(behind.support);
  if (own.length() > params.furniture_length || own.length() > 0.8 * total_length(behind.support)) return false;
  whole = {whole.low - 0.7, whole.high + 0.7};
  return std::min(a, b) > whole.low && std::max(a, b) < whole.high;
}

enum class Bin : char { unknown, solid, open };

// What the raster says of the line at one place: a surface, or rays that go through below any sill.
Bin look(const FreeSpace& space, const WallLine& line, double along) {
  const Eigen::Vector2d p = line.at(along);
  int hits = 0;
  for (const double depth : {-0.04, 0.0, 0.04}) hits = std::max<int>(hits, space.at(p - depth * line.normal).hits);
  int through = 1000000;
  for (const double depth : {0.05, 0.1}) through = std::min<int>(through, space.at(p - depth * line.normal).low);
  if (hits * 4 < through) return Bin::open;
  if (hits > 0) return Bin::solid;
  return Bin::unknown;
}

// Way from a point to the nearest line that looks at it and holds where the way meets it.
template <class Holds>
double way_to_line(const std::vector<WallLine>& lines, const Eigen::Vector2d& from, const Eigen::Vector2d& direction, Holds holds) {
  double least = std::numeric_limits<double>::infinity();
  for (const WallLine& line : lines) {
    const double facing = -line.normal.dot(direction);
    const double distance = line.distance(from);
    if (facing < facing_least || distance < 0 || distance >= least * facing) continue;
    if (holds(line, line.direction().dot(from + distance / facing * direction))) least = distance / facing;
  }
  return least;
}

// Whether a position on a line is next to where its wall has been seen.
bool is_at_wall(const WallLine& line, double at) {
  return std::any_of(line.support.begin(), line.support.end(),
                     [&](const Interval& part) { return at > part.low - jamb_reach && at < part.high + jamb_reach; });
}

// Way to the nearest gap that may be a door, or that is in a wall: what lies behind a door, a pane or a passage adds nothing to a place's width.
double way_to_gap(const std::vector<WallLine>& lines, const Eigen::Vector2d& from, const Eigen::Vector2d& direction, const PlaceParams& params) {
  return way_to_line(lines, from, direction, [&](const WallLine& line, double along) {
    return std::any_of(line.gaps.begin(), line.gaps.end(), [&](const Gap& gap) {
      if (!gap.low_jamb || !gap.high_jamb || along < gap.along.low || along > gap.along.high) return false;
      return gap.along.length() <= params.max_door || (is_at_wall(line, gap.along.low) && is_at_wall(line, gap.along.high));
    });
  });
}

// Free way from a point to the next face or gap, up to `furthest`. Rays pass through a scaffold and over a low wall; its face ends the way.
double free_way(const FreeSpace& space, const std::vector<WallLine>& lines, const Eigen::Vector2d& from, const Eigen::Vector2d& direction,
                const PlaceParams& params) {
  const double end = std::min({furthest, way_to_face(lines, from, direction), way_to_gap(lines, from, direction, params)});
  double way = 0;
  while (way < end && space.at(from + way * direction).free()) way += step;
  return std::min(way, end);
}

// Where the free space beside the middle of a gap runs along the line, on the side that `inwards` looks to; as far as no other face hides it. More
// than `enough` isn't looked for.
Interval floor_beside(const FreeSpace& space, const std::vector<WallLine>& lines, const WallLine& line, const Interval& gap,
                      const Eigen::Vector2d& inwards, double enough, const PlaceParams& params) {
  Interval widest{gap.center(), gap.center()};
  const Eigen::Vector2d middle = line.at(gap.center());
  const double end = way_to_face(lines, middle, inwards);
  for (const double depth : {0.35, 0.5, 0.7, 0.9, 1.1}) {
    const Eigen::Vector2d p = middle + depth * inwards;
    if (depth >= end || widest.length() >= enough || !space.at(p).free()) continue;
    const Interval floor{gap.center() - free_way(space, lines, p, -line.direction(), params),
                         gap.center() + free_way(space, lines, p, line.direction(), params)};
    if (floor.length() > widest.length()) widest = floor;
  }
  return widest;
}

// The line in steps, from before its first face to behind its last.
struct Profile {
  Interval range;
  std::vector<Bin> bins;

  [[nodiscard]] double position(std::size_t i) const { return range.low + (static_cast<double>(i) + 0.5) * step; }
  [[nodiscard]] Interval stretch(std::size_t begin, std::size_t end) const {
    return {range.low + static_cast<double>(begin) * step, range.low + static_cast<double>(end) * step};
  }
};

// Runs of bins that are `open`, or are not.
template <class Visit>
void visit_runs(const std::vector<Bin>& bins, bool open, Visit visit) {
  for (std::size_t i = 0; i < bins.size();) {
    std::size_t end = i;
    while (end < bins.size() && (bins[end] == Bin::open) == open) ++end;
    if (end > i) visit(i, end);
    i = std::max(end, i + 1);
  }
}

constexpr std::size_t rows = 5;  // of cells within the thickness of a wall, and before it

// Hits a ray in the cells behind a place on a line, row by row; 0 where they are too few for a pane.
std::array<double, rows> shares_within(const FreeSpace& space, const WallLine& line, const Eigen::Vector2d& p) {
  std::array<double, rows> shares{};
  for (std::size_t row = 0; row < rows; ++row) {
    const FreeCell& cell = space.at(p - static_cast<double>(row) * step * line.normal);
    if (cell.hits >= least_hits && cell.hits > least_share * cell.low) shares[row] = static_cast<double>(cell.hits) / std::max<int>(cell.low, 1);
  }
  return shares;
}

// Hits a ray on the open floor before some places on a line.
double stray_before(const FreeSpace& space, const WallLine& line, const std::vector<double>& places) {
  double hits = 0;
  double rays = 1;
  for (const double along : places) {
    const Eigen::Vector2d first = line.at(along) + 4 * step * line.normal;
    for (std::size_t row = 0; row < rows; ++row) {
      const FreeCell& cell = space.at(first + static_cast<double>(row) * step * line.normal);
      hits += cell.hits;
      rays += cell.low;
    }
  }
  return hits / rays;
}

// A pane gives back what meets it squarely, at most places along it and at one depth within the thickness of its wall. In the open there are stray
// hits (people who passed, an uneven floor): as many for the rays as before the wall.
void close_panes(const WallLine& line, const FreeSpace& space, Profile& profile) {
  const std::vector<Bin> seen = profile.bins;
  std::vector<std::array<double, rows>> shares(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i] == Bin::open) shares[i] = shares_within(space, line, line.at(profile.position(i)));
  }
  const auto reach = static_cast<std::size_t>(pane / step);
  std::vector<double> open;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i] != Bin::open) continue;
    const std::size_t first = i > reach ? i - reach : 0;
    const std::size_t end = std::min(seen.size(), i + reach + 1);
    open.clear();
    for (std::size_t k = first; k < end; ++k) {
      if (seen[k] == Bin::open) open.push_back(profile.position(k));
    }
    const auto is_pane = [&](double least) {
      for (std::size_t row = 0; row < rows; ++row) {
        std::size_t showing = 0;
        for (std::size_t k = first; k < end; ++k) showing += shares[k][row] > least ? 1 : 0;
        if (showing * 2 > open.size() && static_cast<double>(showing) * step > 2 * loose) return true;
      }
      return false;
    };
    if (is_pane(0) && is_pane(more_than_stray * stray_before(space, line, open))) profile.bins[i] = Bin::solid;
  }
}

// A stretch of the path: its steps end at the points [begin, end).
struct PathPart {
  std::size_t begin, end;
  Eigen::Vector2d center;
  double radius;  // of the circle around its points
};

// So that most of the path needs no look at its points to know that it doesn't cross a line.
std::vector<PathPart> parts_of(const std::vector<Eigen::Vector2d>& path) {
  constexpr std::size_t length = 32;  // steps
  std::vector<PathPart> parts;
  for (std::size_t begin = 1; begin < path.size(); begin += length) {
    PathPart part{begin, std::min(begin + length, path.size()), path[begin - 1], 0};
    part.center = path[(begin + part.end) / 2 - 1];
    for (std::size_t i = begin - 1; i < part.end; ++i) part.radius = std::max(part.radius, (path[i] - part.center).norm());
    parts.push_back(part);
  }
  return parts;
}

Profile profile_of(const WallLine& line, const FreeSpace& space, const std::vector<Eigen::Vector2d>& path, const std::vector<PathPart>& parts,
                   const PlaceParams& params) {
  const Interval whole = hull(line.support);
  Profile profile;
  profile.range = {whole.low - beyond, whole.high + beyond};
  profile.bins.resize(static_cast<std::size_t>(std::ceil(profile.range.length() / step)));
  std::vector<Bin>& bins = profile.bins;
  for (std::size_t i = 0; i < bins.size(); ++i) bins[i] = look(space, line, profile.position(i));
  close_panes(line, space, profile);
  // Where the robot has passed there is no wall, whatever stood or stands there.
  constexpr double rounding = 1e-6;  // [m]
  for (const PathPart& part : parts) {
    if (std::abs(line.distance(part.center)) > part.radius + rounding) continue;
    double b = line.distance(path[part.begin - 1]);
    for (std::size_t i = part.begin; i < part.end; ++i) {
      const double a = b;
      b = line.distance(path[i]);
      if ((a > 0) == (b > 0)) continue;
      const double at = line.direction().dot(path[i - 1] + a / (a - b) * (path[i] - path[i - 1]));
      for (std::size_t k = 0; k < bins.size(); ++k) {
        if (std::abs(profile.position(k) - at) < params.robot_radius) bins[k] = Bin::open;
      }
    }
  }
  // Specks in a gap: a person, a leg of a chair.
  std::vector<std::pair<std::size_t, std::size_t>> specks;
  visit_runs(bins, false, [&](std::size_t begin, std::size_t end) {
    if (begin > 0 && end < bins.size() && static_cast<double>(end - begin) * step <= loose) specks.emplace_back(begin, end);
  });
  for (const auto& [begin, end] : specks)
    std::fill(bins.begin() + static_cast<std::ptrdiff_t>(begin), bins.begin() + static_cast<std::ptrdiff_t>(end), Bin::open);
  return profile;
}

// What the faces' outlines claim and rays go through isn't wall: an outline is convex and holds doors too.
void correct_support(WallLine& line, const Profile& profile) {
  Intervals open;
  visit_runs(profile.bins, true, [&](std::size_t begin, std::size_t end) { open.push_back(profile.stretch(begin, end)); });
  Intervals seen;
  for (const Interval& part : line.support) {
    for (const Interval& rest : gaps(open, part, step)) seen.push_back(rest);
  }
  line.support = unite(std::move(seen), 2 * step);
  // Where an outline reaches over a door and across another wall, a scrap of that wall is left at its end.
  const auto is_scrap = [](const Interval& part, const Interval& next) { return part.length() < scrap && -overlap(part, next) > part.length(); };
  Intervals& parts = line.support;
  while (parts.size() > 1 && is_scrap(parts.front(), parts[1])) parts.erase(parts.begin());
  while (parts.size() > 1 && is_scrap(parts.back(), parts[parts.size() - 2])) parts.pop_back();
}

// The gaps of a line, and where it bounds.
void find_gaps(WallLine& line, const Profile& profile, const PlaceParams& params) {
  const Interval whole = hull(line.support);
  Intervals holes;
  visit_runs(profile.bins, true, [&](std::size_t begin, std::size_t end) {
    Gap gap;
    gap.along = profile.stretch(begin, end);
    gap.low_jamb = begin > 0;
    gap.high_jamb = end < profile.bins.size();
    if (gap.along.length() < params.min_door) return;
    line.gaps.push_back(gap);
    holes.push_back(gap.along);
  });
  // Solid: what has been seen, what nobody sees between, and the short way to the next corner.
  Intervals solid;
  for (const Interval& part : gaps(holes, profile.range)) {
    Interval bounded = part;
    bounded.low = std::max(bounded.low, whole.low);
    bounded.high = std::min(bounded.high, whole.high);
    if (bounded.length() > 0) solid.push_back(bounded);
  }
  line.solid = unite(std::move(solid));
}

// Which gaps of a line part two places: doors, and openings that leave at least half of the floor's width walled off. Of a row of columns with wide
// gaps between them all count.
void find_cuts(WallLine& line, const std::vector<WallLine>& lines, const FreeSpace& space, const PlaceParams& params) {
  Intervals wide;
  for (const Gap& gap : line.gaps) {
    if (gap.along.length() > params.max_door) wide.push_back(gap.along);
  }
  for (Gap& gap : line.gaps) {
    if (!gap.low_jamb || !gap.high_jamb || total_length(line.support) < params.furniture_depth) continue;
    const double width = gap.along.length();
    const bool is_wide = width > params.max_door;
    const double enough = is_wide ? furthest : std::max(width + cross_section_margin, width / most_of_section);
    const Interval front = floor_beside(space, lines, line, gap.along, line.normal, enough, params);
    const Interval back = floor_beside(space, lines, line, gap.along, -line.normal, enough, params);
    const Interval& floor = front.length() < back.length() ? front : back;
    const double narrower = floor.length();
    // What takes up most of a corridor's width is a door when wall ends it on both sides: a cupboard at one side of a corridor leaves a gap too.
    if (width > most_of_section * narrower && !(is_at_wall(line, gap.along.low) && is_at_wall(line, gap.along.high))) continue;
    gap.cut = is_wide ? total_length(clip(wide, floor)) <= params.join_share * narrower : narrower >= width + cross_section_margin;
  }
}

}  // namespace

double trust(const Wall& wall) {
  constexpr double known_well = 10;  // views
  const auto views = static_cast<double>(wall.views);
  return (1 + views) / (known_well + views);
}

double way_to_face(const std::vector<WallLine>& lines, const Eigen::Vector2d& from, const Eigen::Vector2d& direction) {
  return way_to_line(lines, from, direction, [](const WallLine& line, double along) {
    return std::any_of(line.solid.begin(), line.solid.end(), [&](const Interval& part) { return along >= part.low && along <= part.high; });
  });
}

std::vector<WallLine> find_wall_lines(const std::vector<Wall>& walls, const FreeSpace& space, const std::vector<Eigen::Vector2d>& path,
                                      const PlaceParams& params) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    if (walls[i].length() >= shortest_face) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return weight(walls[a]) > weight(walls[b]); });
  std::vector<WallLine> lines;
  for (const std::size_t i : order) {
    const auto line = std::find_if(lines.begin(), lines.end(), [&](const WallLine& l) { return fits(l, walls[i], params.coplanar); });
    if (line != lines.end()) {
      add_face(*line, walls[i], i);
    } else {
      WallLine fresh;
      fresh.normal = walls[i].normal;
      fresh.offset = walls[i].offset;
      add_face(fresh, walls[i], i);
      lines.push_back(std::move(fresh));
    }
  }
  const std::vector<PathPart> parts = parts_of(path);
  std::vector<Profile> profiles;
  for (WallLine& line : lines) {
    profiles.push_back(profile_of(line, space, path, parts, params));
    correct_support(line, profiles.back());
  }
  std::vector<WallLine> bounding;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (total_length(lines[i].support) < shortest_face) continue;
    const auto hides = [&](const WallLine& other) { return &other != &lines[i] && is_furniture(lines[i], other, params); };
    if (std::any_of(lines.begin(), lines.end(), hides)) continue;
    bounding.push_back(lines[i]);
    find_gaps(bounding.back(), profiles[i], params);
  }
  for (WallLine& line : bounding) find_cuts(line, bounding, space, params);
  return bounding;
}

}  // namespace sgraph
