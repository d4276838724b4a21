#include "sgraph_slam/core/places/regions.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include <opencv2/imgproc.hpp>

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
cv::Mat open_cells(const FreeSpace& space, const CellWindow& window, const std::vector<WallLine>& lines) {
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
  cv::Mat open = cv::Mat::zeros(window.height, window.width, CV_8U);
  for (int y = 1; y < window.height - 1; ++y) {
    const FreeCell* row =
        &space.cells()[static_cast<std::size_t>(y + window.y) * static_cast<std::size_t>(space.width()) + static_cast<std::size_t>(window.x)];
    const uchar* bar = barrier.ptr<uchar>(y);
    uchar* out = open.ptr<uchar>(y);
    for (int x = 1; x < window.width - 1; ++x) {
      if (bar[x] == 0 && row[x].free()) out[x] = 255;
    }
  }
  return open;
}

// Numbers the pieces that a disc of the robot's radius can pass between and that are large enough to be one.
void label_cores(const cv::Mat& core, double least_cells, Regions& regions) {
  cv::Mat labels;
  cv::Mat stats;
  cv::Mat centers;
  const int n = cv::connectedComponentsWithStats(core, labels, stats, centers, 4, CV_32S);
  std::vector<std::int32_t> number(static_cast<std::size_t>(n), -1);
  for (int i = 1; i < n; ++i) {
    if (stats.at<int>(i, cv::CC_STAT_AREA) >= least_cells) number[static_cast<std::size_t>(i)] = regions.count++;
  }
  auto label = regions.label.begin();
  for (int y = 0; y < core.rows; ++y) {
    const int* row = labels.ptr<int>(y);
    for (int x = 0; x < core.cols; ++x) *label++ = number[static_cast<std::size_t>(row[x])];
  }
}

// Gives the rest of the open cells to the piece that reaches them first. Nothing is open at the window's border.
void grow(const cv::Mat& open, Regions& regions) {
  const auto width = static_cast<std::ptrdiff_t>(open.cols);
  const std::array<std::ptrdiff_t, 4> ways{1, -1, width, -width};
  const uchar* is_open = open.ptr<uchar>();
  std::vector<std::int32_t>& label = regions.label;
  const auto at = [](std::ptrdiff_t i) { return static_cast<std::size_t>(i); };
  std::vector<std::ptrdiff_t> front;
  for (std::ptrdiff_t i = width; i + width < static_cast<std::ptrdiff_t>(label.size()); ++i) {
    if (label[at(i)] < 0) continue;
    const auto is_free = [&](std::ptrdiff_t way) { return label[at(i + way)] < 0 && is_open[i + way] != 0; };
    if (std::any_of(ways.begin(), ways.end(), is_free)) front.push_back(i);
  }
  for (std::size_t next = 0; next < front.size(); ++next) {
    const std::ptrdiff_t i = front[next];
    for (const std::ptrdiff_t way : ways) {
      std::int32_t& neighbour = label[at(i + way)];
      if (neighbour >= 0 || is_open[i + way] == 0) continue;
      neighbour = label[at(i)];
      front.push_back(i + way);
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

Regions find_regions(const FreeSpace& space, const std::vector<WallLine>& lines, const std::vector<Eigen::Vector2d>& path,
                     const PlaceParams& params) {
  Regions regions;
  regions.window = window_around(space, lines, path);
  const int w = regions.window.width;
  const int h = regions.window.height;
  if (w <= 2 || h <= 2) return {};
  regions.label.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  const cv::Mat open = open_cells(space, regions.window, lines);
  cv::Mat distance;
  cv::distanceTransform(open, distance, cv::DIST_L2, cv::DIST_MASK_5);
  const double cell_area = space.resolution() * space.resolution();
  label_cores(distance > params.robot_radius / space.resolution(), 0.3 * params.min_area / cell_area, regions);
  grow(open, regions);
  measure_extents(regions);
  regions.entered.assign(static_cast<std::size_t>(regions.count), 0);
  for (const Eigen::Vector2d& p : path) {
    const Eigen::Vector2d c = ((p - space.origin()) / space.resolution()).array().floor();
    const int x = static_cast<int>(c.x()) - regions.window.x;
    const int y = static_cast<int>(c.y()) - regions.window.y;
    if (x < 0 || y < 0 || x >= w || y >= h) continue;
    const int region = regions.label[static_cast<std::size_t>(y * w + x)];
    if (region >= 0 && distance.at<float>(y, x) * space.resolution() > min_depth + params.robot_radius)
      regions.entered[static_cast<std::size_t>(region)] = 1;
  }
  return regions;
}

}  // namespace sgraph
