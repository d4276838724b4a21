#include "sgraph_slam/core/places/regions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include <Eigen/Geometry>

#include <opencv2/imgproc.hpp>

#include "sgraph_slam/core/places/cell_bits.hpp"

namespace sgraph {
namespace {

constexpr double corner = 0.2;     // a solid stretch is drawn this far beyond its ends: it may end a little before the corner [m]
constexpr double edge = 1.0;       // of the window beyond the walls [m]
constexpr int shift = 4;           // OpenCV takes 1/16 cells
constexpr double min_depth = 0.1;  // an entered place has the robot this far inside [m]

cv::Point cell_of(const FreeSpace& space, const CellWindow& window, const Eigen::Vector2d& p) {
  const Eigen::Vector2d c = (p - space.origin()) / space.resolution() - Eigen::Vector2d(window.x + 0.5, window.y + 0.5);
  return {static_cast<int>(std::lround(c.x() * (1 << shift))), static_cast<int>(std::lround(c.y() * (1 << shift)))};
}

// Around the walls and the path, with a margin.
CellWindow window_around(const FreeSpace& space, const std::vector<WallLine>& lines, const std::vector<Eigen::Vector2d>& path) {
  Eigen::AlignedBox2d box;
  for (const WallLine& line : lines) {
    for (const Interval& part : line.support) box.extend(line.at(part.low)).extend(line.at(part.high));
  }
  for (const Eigen::Vector2d& p : path) box.extend(p);
  if (box.isEmpty()) return {};
  const Eigen::Vector2d first = ((box.min() - space.origin()).array() - edge) / space.resolution();
  const Eigen::Vector2d last = ((box.max() - space.origin()).array() + edge) / space.resolution();
  const auto within = [](double value, int most) { return std::clamp(static_cast<int>(value), 0, most); };
  const int x = within(first.x(), space.width());
  const int y = within(first.y(), space.height());
  return {x, y, within(last.x(), space.width()) - x, within(last.y(), space.height()) - y};
}

void draw(cv::Mat& barrier, const FreeSpace& space, const CellWindow& window, const WallLine& line, Interval part) {
  // Just behind the face: the cells before it stay free.
  const Eigen::Vector2d behind = -0.5 * space.resolution() * line.normal;
  cv::line(barrier, cell_of(space, window, line.at(part.low) + behind), cell_of(space, window, line.at(part.high) + behind), cv::Scalar(255), 1,
           cv::LINE_4, shift);
}

// Cells that nothing bounds: free, and on no wall or cut. None at the border of the window.
CellBits open_cells(const FreeSpace& space, const CellWindow& window, const std::vector<WallLine>& lines) {
  cv::Mat barrier = cv::Mat::zeros(window.height, window.width, CV_8U);
  for (const WallLine& line : lines) {
    const auto jamb_near = [&](double at) {
      return std::any_of(line.gaps.begin(), line.gaps.end(),
                         [&](const Gap& gap) { return std::abs(gap.along.low - at) < 0.01 || std::abs(gap.along.high - at) < 0.01; });
    };
    for (const Interval& part : line.solid)
      draw(barrier, space, window, line, {part.low - (jamb_near(part.low) ? 0 : corner), part.high + (jamb_near(part.high) ? 0 : corner)});
    for (const Gap& gap : line.gaps) {
      if (gap.cut) draw(barrier, space, window, line, {gap.along.low - space.resolution(), gap.along.high + space.resolution()});
    }
  }
  CellBits open = space.free_cells().inside(window.x, window.y, window.width, window.height);
  for (int y = 1; y < window.height - 1; ++y) {
    const uchar* bar = barrier.ptr<uchar>(y);
    // Most cells are on no wall: eight of them are asked at once.
    int x = 0;
    for (; x + 8 <= window.width; x += 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, bar + x, sizeof eight);
      if (eight == 0) continue;
      for (int k = x; k < x + 8; ++k) {
        if (bar[k] != 0) open.put(k, y, false);
      }
    }
    for (; x < window.width; ++x) {
      if (bar[x] != 0) open.put(x, y, false);
    }
  }
  return open;
}

// Numbers the pieces that are large enough to be one, in the order of their first cells, row by row. Returns their cells.
CellBits label_cores(const CellBits& core, double least_cells, Regions& regions) {
  struct Run {
    int y, begin, end;
    std::size_t piece;  // the first run of its piece, by way of others
  };
  std::vector<Run> runs;
  const auto first_of = [&runs](std::size_t run) {
    while (runs[run].piece != run) run = runs[run].piece = runs[runs[run].piece].piece;
    return run;
  };
  std::size_t above = 0;  // the first run of the row above
  for (int y = 0; y < core.height(); ++y) {
    const std::size_t row = runs.size();
    core.visit_runs(y, [&](int begin, int end) {
      const std::size_t own = runs.size();
      runs.push_back({y, begin, end, own});
      while (above < row && runs[above].end <= begin) ++above;
      for (std::size_t other = above; other < row && runs[other].begin < end; ++other) {
        const auto [low, high] = std::minmax({first_of(own), first_of(other)});
        runs[high].piece = low;
      }
    });
    above = row;
  }
  std::vector<double> cells(runs.size(), 0);
  for (std::size_t i = 0; i < runs.size(); ++i) cells[first_of(i)] += runs[i].end - runs[i].begin;
  std::vector<std::int32_t> number(runs.size(), -1);
  CellBits labelled(core.width(), core.height());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::size_t piece = first_of(i);
    if (piece == i && cells[i] >= least_cells) number[i] = regions.count++;
    if (number[piece] < 0) continue;
    labelled.set(runs[i].y, runs[i].begin, runs[i].end);
    const auto begin = regions.label.begin() + static_cast<std::ptrdiff_t>(runs[i].y) * core.width();
    std::fill(begin + runs[i].begin, begin + runs[i].end, number[piece]);
  }
  return labelled;
}

// Gives the rest of the open cells to the piece that reaches them first. Nothing is open at the window's border.
void grow(const CellBits& open, const CellBits& labelled, Regions& regions) {
  CellBits rest = open.without(labelled);
  std::vector<Eigen::Vector2i> front;
  labelled.visit_beside(rest, [&front](int x, int y) { front.emplace_back(x, y); });
  const std::array<Eigen::Vector2i, 4> ways{Eigen::Vector2i(1, 0), Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, 1), Eigen::Vector2i(0, -1)};
  const auto label = [&](const Eigen::Vector2i& cell) -> std::int32_t& {
    return regions.label[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(regions.window.width) + static_cast<std::size_t>(cell.x())];
  };
  for (std::size_t next = 0; next < front.size(); ++next) {
    const Eigen::Vector2i cell = front[next];
    for (const Eigen::Vector2i& way : ways) {
      const Eigen::Vector2i neighbour = cell + way;
      if (!rest.take(neighbour.x(), neighbour.y())) continue;
      label(neighbour) = label(cell);
      front.push_back(neighbour);
    }
  }
}

void measure_extents(Regions& regions) {
  std::vector<Eigen::AlignedBox2i> boxes(static_cast<std::size_t>(regions.count));
  auto label = regions.label.begin();
  for (int y = 0; y < regions.window.height; ++y) {
    std::int32_t before = -1;
    for (int x = 0; x < regions.window.width; ++x) {
      const std::int32_t region = *label++;
      // The ends of a run are enough.
      if (region != before && before >= 0) boxes[static_cast<std::size_t>(before)].extend(Eigen::Vector2i(x - 1, y));
      if (region != before && region >= 0) boxes[static_cast<std::size_t>(region)].extend(Eigen::Vector2i(x, y));
      before = region;
    }
    if (before >= 0) boxes[static_cast<std::size_t>(before)].extend(Eigen::Vector2i(regions.window.width - 1, y));
  }
  for (const Eigen::AlignedBox2i& box : boxes)
    regions.extent.push_back({regions.window.x + box.min().x(), regions.window.y + box.min().y(), box.sizes().x() + 1, box.sizes().y() + 1});
}

}  // namespace

Regions find_regions(const FreeSpace& space, const std::vector<WallLine>& lines, const std::vector<Eigen::Vector2d>& path, const PlaceParams& params,
                     Regions used) {
  Regions regions;
  regions.label = std::move(used.label);
  regions.window = window_around(space, lines, path);
  const int w = regions.window.width;
  const int h = regions.window.height;
  if (w <= 2 || h <= 2) return {};
  regions.label.assign(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), -1);
  const CellBits open = open_cells(space, regions.window, lines);
  const double cell = space.resolution();
  const auto in_core = [&](float cells) { return cells > static_cast<float>(params.robot_radius / cell); };
  const auto is_deep = [&](float cells) { return cells * cell > min_depth + params.robot_radius; };
  const CellBits labelled = label_cores(further_inside(open, in_core), 0.3 * params.min_area / (cell * cell), regions);
  grow(open, labelled, regions);
  measure_extents(regions);
  const CellBits deep = further_inside(open, is_deep);
  regions.entered.assign(static_cast<std::size_t>(regions.count), 0);
  for (const Eigen::Vector2d& p : path) {
    const Eigen::Vector2d c = ((p - space.origin()) / space.resolution()).array().floor();
    const int x = static_cast<int>(c.x()) - regions.window.x;
    const int y = static_cast<int>(c.y()) - regions.window.y;
    if (x < 0 || y < 0 || x >= w || y >= h) continue;
    const int region = regions.label[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)];
    if (region >= 0 && deep.at(x, y)) regions.entered[static_cast<std::size_t>(region)] = 1;
  }
  return regions;
}

}  // namespace sgraph
