#include "sgraph_slam/core/places/islands.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <opencv2/imgproc.hpp>

namespace sgraph {
namespace {

constexpr double step = 0.05;                            // along a line [m]
constexpr std::array<double, 2> within_wall{0.05, 0.1};  // behind a face: no wall is thinner [m]
constexpr std::array<double, 2> beyond_niche{0.3, 0.4};  // over a niche with a window rays end sooner [m]
constexpr std::uint16_t least_views = 2;                 // keyframes that saw past it: one may be mistaken
constexpr double most = 0.5;                             // share of a face
constexpr double same_direction = 0.12;                  // [rad]
constexpr double deepest = 5.0;                          // what stands at a wall: a parked car [m]
constexpr double before_face = 0.25;                     // the floor begins this near to a face [m]
constexpr double corner = 0.2;                           // a wall may end a little before its corner [m]

// Visits the stretches of a line that bound, in steps: positions just behind the face.
template <class Visit>
void visit_behind(const WallLine& line, Visit visit) {
  for (const Interval& part : line.solid) {
    for (double s = part.low + 0.5 * step; s < part.high; s += step) visit(line.at(s));
  }
}

bool passed_over(const FreeSpace& space, const WallLine& line, const Eigen::Vector2d& p) {
  const auto passed = [&](double depth) { return space.at(p - depth * line.normal).over >= least_views; };
  return std::all_of(within_wall.begin(), within_wall.end(), passed) && std::any_of(beyond_niche.begin(), beyond_niche.end(), passed);
}

bool reaches_ceiling(const FreeSpace& space, const WallLine& line) {
  int all = 0;
  int over = 0;
  visit_behind(line, [&](const Eigen::Vector2d& p) {
    ++all;
    over += passed_over(space, line, p) ? 1 : 0;
  });
  return over <= most * all;
}

// What is no floor of an entered place, in connected pieces.
struct Pieces {
  cv::Mat label;             // by cell of the window: 0 for the floor of a place
  std::vector<char> island;  // by label: a single place surrounds it
};

Pieces find_pieces(const Regions& regions) {
  const int w = regions.window.width;
  const int h = regions.window.height;
  const auto place_at = [&](int x, int y) {
    const std::int32_t region = regions.label[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)];
    return region >= 0 && regions.entered[static_cast<std::size_t>(region)] ? region : -1;
  };
  cv::Mat other(h, w, CV_8U);
  for (int y = 0; y < h; ++y) {
    auto* row = other.ptr<uchar>(y);
    for (int x = 0; x < w; ++x) row[x] = place_at(x, y) < 0 ? 255 : 0;
  }
  Pieces pieces;
  const int n = cv::connectedComponents(other, pieces.label, 8, CV_32S);
  constexpr int nobody = -1;
  constexpr int several = -2;
  std::vector<int> neighbour(static_cast<std::size_t>(n), nobody);
  const auto touch = [&](int piece, int place) {
    int& known = neighbour[static_cast<std::size_t>(piece)];
    if (known == nobody) known = place;
    if (known != place) known = several;
  };
  const auto meet = [&](int x, int y, int piece, int next_x, int next_y, int next_piece) {
    if (piece == 0 && next_piece != 0) touch(next_piece, place_at(x, y));
    if (piece != 0 && next_piece == 0) touch(piece, place_at(next_x, next_y));
  };
  for (int y = 0; y < h; ++y) {
    const int* row = pieces.label.ptr<int>(y);
    const int* above = y + 1 < h ? pieces.label.ptr<int>(y + 1) : nullptr;
    for (int x = 0; x < w; ++x) {
      if (x + 1 < w && row[x] != row[x + 1]) meet(x, y, row[x], x + 1, y, row[x + 1]);
      if (above != nullptr && row[x] != above[x]) meet(x, y, row[x], x, y + 1, above[x]);
    }
  }
  pieces.island.assign(static_cast<std::size_t>(n), 0);
  for (int i = 1; i < n; ++i) pieces.island[static_cast<std::size_t>(i)] = neighbour[static_cast<std::size_t>(i)] >= 0;
  // The border of the window is no floor: what touches it is outside.
  for (int x = 0; x < w; ++x) pieces.island[static_cast<std::size_t>(pieces.label.at<int>(0, x))] = 0;
  return pieces;
}

// Where a line goes on behind what stands before it: the way from a point against the normal, to the nearest face that looks the same way.
double way_to_wall(const std::vector<const WallLine*>& walls, const WallLine& line, const Eigen::Vector2d& p) {
  double least = deepest;
  for (const WallLine* wall : walls) {
    const double facing = wall->normal.dot(line.normal);
    if (facing < std::cos(same_direction)) continue;
    const double way = wall->distance(p) / facing;
    if (way <= 0 || way >= least) continue;
    const double along = wall->direction().dot(p - way * line.normal);
    const auto holds = [&](const Interval& part) { return along > part.low - corner && along < part.high + corner; };
    if (std::any_of(wall->solid.begin(), wall->solid.end(), holds)) least = way;
  }
  return least;
}

// Whether what a low face bounds ends in the place before it, or at a wall that looks as it does, without floor of another piece before that.
bool stands_within(const FreeSpace& space, const std::function<int(const Eigen::Vector2d&)>& region_at, const std::vector<const WallLine*>& walls,
                   const WallLine& line, const Eigen::Vector2d& p) {
  int front = -1;
  for (double way = step; way <= before_face && front < 0; way += step) front = region_at(p + way * line.normal);
  if (front < 0) return false;
  const double end = way_to_wall(walls, line, p);
  for (double way = 2 * step; way < end - step; way += step) {
    const Eigen::Vector2d behind = p - way * line.normal;
    const int region = region_at(behind);
    if (region == front) return true;
    if (region >= 0 && space.at(behind).low > 0) return false;  // without rays close to the floor it is what has been seen over the face
  }
  return end < deepest;
}

}  // namespace

void join_over_low_lines(const FreeSpace& space, const PlaceParams& params, std::vector<WallLine>& lines) {
  for (WallLine& line : lines) {
    const auto is_wide = [&](const Gap& gap) { return gap.cut && gap.along.length() > params.max_door; };
    if (std::none_of(line.gaps.begin(), line.gaps.end(), is_wide) || reaches_ceiling(space, line)) continue;
    for (Gap& gap : line.gaps) gap.cut = gap.cut && !is_wide(gap);
  }
}

bool join_recesses(const FreeSpace& space, const Regions& regions, std::vector<WallLine>& lines) {
  const auto region_beside = [&](const Eigen::Vector2d& p, const Eigen::Vector2d& way) {
    for (double depth = 2 * step; depth <= 0.5; depth += step) {
      const Eigen::Vector2d c = ((p + depth * way - space.origin()) / space.resolution()).array().floor();
      const int region = regions.at(static_cast<int>(c.x()), static_cast<int>(c.y()));
      if (region >= 0) return region;
    }
    return -1;
  };
  const auto entered = [&](int region) { return region >= 0 && regions.entered[static_cast<std::size_t>(region)] != 0; };
  const auto is_recess = [&](int region) {
    if (region < 0 || entered(region)) return false;
    const CellWindow& extent = regions.extent[static_cast<std::size_t>(region)];
    return space.resolution() * std::min(extent.width, extent.height) <= deepest;
  };
  bool joined = false;
  for (WallLine& line : lines) {
    if (std::none_of(line.gaps.begin(), line.gaps.end(), [](const Gap& gap) { return gap.cut; }) || reaches_ceiling(space, line)) continue;
    for (Gap& gap : line.gaps) {
      if (!gap.cut) continue;
      const int front = region_beside(line.at(gap.along.center()), line.normal);
      const int back = region_beside(line.at(gap.along.center()), -line.normal);
      if (!(entered(front) && is_recess(back)) && !(entered(back) && is_recess(front))) continue;
      gap.cut = false;
      joined = true;
    }
  }
  return joined;
}

bool drop_islands(const FreeSpace& space, const Regions& regions, std::vector<WallLine>& lines) {
  std::vector<char> low(lines.size(), 0);
  for (std::size_t k = 0; k < lines.size(); ++k) low[k] = !reaches_ceiling(space, lines[k]);
  if (std::find(low.begin(), low.end(), 1) == low.end() || regions.count == 0) return false;
  std::vector<const WallLine*> walls;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (!low[k]) walls.push_back(&lines[k]);
  }
  const auto region_at = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d c = ((p - space.origin()) / space.resolution()).array().floor();
    return regions.at(static_cast<int>(c.x()), static_cast<int>(c.y()));
  };
  std::vector<char> within_place(lines.size(), 0);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (!low[k]) continue;
    int all = 0;
    int within = 0;
    visit_behind(lines[k], [&](const Eigen::Vector2d& p) {
      ++all;
      within += stands_within(space, region_at, walls, lines[k], p) ? 1 : 0;
    });
    within_place[k] = within > most * all;
  }
  const Pieces pieces = find_pieces(regions);
  const auto piece_at = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d c = ((p - space.origin()) / space.resolution()).array().floor();
    const int x = static_cast<int>(c.x()) - regions.window.x;
    const int y = static_cast<int>(c.y()) - regions.window.y;
    return x < 0 || y < 0 || x >= regions.window.width || y >= regions.window.height ? 0 : pieces.label.at<int>(y, x);
  };
  // An island is low when most of what bounds it is.
  std::vector<double> bounded(pieces.island.size(), 0);
  std::vector<double> passed(pieces.island.size(), 0);
  std::vector<std::vector<int>> at(lines.size());
  for (std::size_t k = 0; k < lines.size(); ++k) {
    visit_behind(lines[k], [&](const Eigen::Vector2d& p) {
      const int piece = piece_at(p - within_wall[0] * lines[k].normal);
      at[k].push_back(piece);
      bounded[static_cast<std::size_t>(piece)] += step;
      if (passed_over(space, lines[k], p)) passed[static_cast<std::size_t>(piece)] += step;
    });
  }
  std::vector<WallLine> kept;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const auto is_low = [&](int piece) {
      const auto i = static_cast<std::size_t>(piece);
      return pieces.island[i] && passed[i] > most * bounded[i];
    };
    const auto within = std::count_if(at[k].begin(), at[k].end(), is_low);
    if (!within_place[k] && 2 * static_cast<std::size_t>(within) <= at[k].size()) kept.push_back(std::move(lines[k]));
  }
  const bool dropped = kept.size() < lines.size();
  lines = std::move(kept);
  return dropped;
}

}  // namespace sgraph
