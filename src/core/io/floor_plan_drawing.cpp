#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "canvas.hpp"
#include "sgraph_slam/core/io/floor_plan.hpp"

namespace sgraph {
namespace {

constexpr double longer_side = 1600;  // of the picture [px]
constexpr double margin = 90;         // holds title, scale bar and legend [px]
constexpr double least_side = 700;
constexpr double least_solid = 0.2;  // what stands on the floor with less of its length is a beam under the ceiling, not a wall with doors

constexpr Color ink{38, 42, 48};
constexpr Color furniture_ink{140, 145, 152};
constexpr Color hidden_ink{190, 194, 200};
constexpr Color obstacle_ink{200, 203, 209};
constexpr Color free_fill{245, 246, 248};
constexpr Color path_ink{32, 98, 196};
constexpr Color start_ink{30, 150, 70};
constexpr Color end_ink{210, 50, 45};
constexpr Color outline_ink{120, 128, 140};
constexpr Color door_ink{196, 112, 20};
constexpr Color corridor_fill{255, 244, 214};
constexpr Color room_fills[] = {{222, 236, 250}, {225, 244, 226}, {250, 228, 224}, {236, 228, 247}, {221, 243, 243}, {247, 236, 222}};

// From the map to the page: walls along its sides, y up.
class Layout {
 public:
  explicit Layout(const FloorPlan& plan) : to_page_(-plan.yaw) {
    Eigen::AlignedBox2d box;
    for (const DrawnWall& wall : plan.walls) box.extend(turned(wall.line.first)).extend(turned(wall.line.second));
    for (const DrawnPlace& place : plan.places) {
      for (const auto& corner : place.outline) box.extend(turned(corner));
    }
    for (const auto& p : plan.path) box.extend(turned(p));
    extend_by_most(box, plan.obstacles);
    if (box.isEmpty()) box.extend(Eigen::Vector2d(-5, -5)).extend(Eigen::Vector2d(5, 5));
    const Eigen::Vector2d size = box.sizes().cwiseMax(1.0);
    scale_ = std::min({(longer_side - 2 * margin) / size.x(), (longer_side - 2 * margin) / size.y(), 200.0});
    const auto side = [this](double metres) { return std::max(least_side, metres * scale_ + 2 * margin); };
    width_ = static_cast<int>(side(size.x()));
    height_ = static_cast<int>(side(size.y()));
    center_ = box.center();
  }

  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& p_map) const {
    const Eigen::Vector2d p = scale_ * (turned(p_map) - center_);
    return {0.5 * width_ + p.x(), 0.5 * height_ - p.y()};
  }
  [[nodiscard]] Eigen::Vector2d direction(const Eigen::Vector2d& in_map) const {
    const Eigen::Vector2d d = turned(in_map);
    return {d.x(), -d.y()};
  }
  [[nodiscard]] double scale() const { return scale_; }  // px a metre
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

 private:
  [[nodiscard]] Eigen::Vector2d turned(const Eigen::Vector2d& p_map) const { return to_page_ * p_map; }

  // All but the outermost half percent at each side: a reflection far away must not shrink the building.
  void extend_by_most(Eigen::AlignedBox2d& box, const std::vector<Segment2d>& obstacles) const {
    if (obstacles.empty()) return;
    std::vector<double> xs;
    std::vector<double> ys;
    for (const auto& [first, last] : obstacles) {
      const Eigen::Vector2d p = turned(first);
      xs.push_back(p.x());
      ys.push_back(p.y());
    }
    std::sort(xs.begin(), xs.end());
    std::sort(ys.begin(), ys.end());
    const std::size_t skip = xs.size() / 200;
    box.extend(Eigen::Vector2d(xs[skip], ys[skip])).extend(Eigen::Vector2d(xs[xs.size() - 1 - skip], ys[ys.size() - 1 - skip]));
  }

  Eigen::Rotation2Dd to_page_;
  Eigen::Vector2d center_;
  double scale_ = 1;
  int width_ = 0;
  int height_ = 0;
};

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

void draw_cells(Canvas& canvas, const Layout& layout, const std::vector<Segment2d>& rows, double cell, Color color) {
  std::vector<Canvas::Points> cells;
  const double half = 0.5 * cell;
  for (const auto& [first, last] : rows) {
    cells.push_back({layout(first + Eigen::Vector2d(-half, -half)), layout(last + Eigen::Vector2d(half, -half)),
                     layout(last + Eigen::Vector2d(half, half)), layout(first + Eigen::Vector2d(-half, half))});
  }
  canvas.fill_all(cells, color);
}

// How much of a wall stands on the floor.
double share_solid(const DrawnWall& wall) {
  double length = 0;
  for (const auto& [from, to] : wall.solid) length += (to - from).norm();
  return length / (wall.line.second - wall.line.first).norm();
}

void draw_walls(Canvas& canvas, const Layout& layout, const FloorPlan& plan) {
  const double width = std::clamp(0.07 * layout.scale(), 2.5, 6.0);
  for (const DrawnWall& wall : plan.walls) {
    if (!wall.low && share_solid(wall) > least_solid) canvas.dashed(layout(wall.line.first), layout(wall.line.second), hidden_ink, 1.2);
  }
  for (const bool low : {true, false}) {
    for (const DrawnWall& wall : plan.walls) {
      if (wall.low != low) continue;
      for (const auto& [from, to] : wall.solid) canvas.line({layout(from), layout(to)}, low ? furniture_ink : ink, low ? 0.5 * width : width);
    }
  }
}

Canvas::Points on_page(const Layout& layout, const std::vector<Eigen::Vector2d>& corners) {
  Canvas::Points points;
  for (const auto& corner : corners) points.push_back(layout(corner));
  return points;
}

void draw_label(Canvas& canvas, const Layout& layout, const DrawnPlace& place) {
  if (place.name.empty()) return;
  Eigen::AlignedBox2d box;
  for (const auto& corner : place.outline) box.extend(layout(corner));
  const bool rectangle = place.size.x() > 0;
  const std::string size = rectangle ? metres(place.size.x()) + " x " + metres(place.size.y()) + " m" : metres(place.area) + " m2";
  constexpr double width_of_letter = 0.62;  // of the size
  const double wide = 0.92 * box.sizes().x() / (width_of_letter * static_cast<double>(std::max(size.size(), place.name.size())));
  const double letter = std::clamp(std::min(wide, 0.36 * box.sizes().y()), 11.0, 26.0);
  const Eigen::Vector2d at = layout(place.center);
  canvas.text(at - Eigen::Vector2d(0, 0.25 * letter), place.name, letter, ink, Anchor::middle, true);
  canvas.text(at + Eigen::Vector2d(0, 0.95 * letter), size, 0.85 * letter, ink, Anchor::middle);
}

// The gap, the leaf's swing as a plan shows it, and the width.
void draw_doors(Canvas& canvas, const Layout& layout, const FloorPlan& plan) {
  constexpr int steps = 8;  // of the quarter circle
  for (const DrawnDoor& door : plan.doors) {
    const Eigen::Vector2d through(std::cos(door.yaw), std::sin(door.yaw));
    const Eigen::Vector2d along(-through.y(), through.x());
    const Eigen::Vector2d hinge = door.center - 0.5 * door.width * along;
    Canvas::Points swing;
    for (int i = 0; i <= steps; ++i) {
      const double angle = 0.5 * M_PI * i / steps;
      swing.push_back(layout(hinge + door.width * (std::cos(angle) * along + std::sin(angle) * through)));
    }
    canvas.line({layout(hinge), layout(hinge + door.width * along)}, door_ink, 3);
    canvas.line(swing, door_ink, 1.2);
    canvas.line({layout(hinge), swing.back()}, door_ink, 1.2);
    if (layout.scale() < 25) continue;  // no room for figures
    canvas.text(layout(door.center - 0.35 * through) + Eigen::Vector2d(0, 4), metres(door.width), 11, door_ink, Anchor::middle);
  }
}

void draw_path(Canvas& canvas, const Layout& layout, const FloorPlan& plan) {
  if (plan.path.empty()) return;
  Canvas::Points points;
  for (const auto& p : plan.path) points.push_back(layout(p));
  canvas.line(points, path_ink, 2.2);
  canvas.disc(points.front(), 9, start_ink);
  canvas.disc(points.back(), 5.5, end_ink);  // smaller: the start shows behind it where a walk ends where it began
}

// The largest round length that is at most a quarter of the picture.
double bar_length(const Layout& layout) {
  const double longest = 0.25 * layout.width() / layout.scale();
  double length = std::pow(10, std::floor(std::log10(longest)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * length <= longest) return factor * length;
  }
  return length;
}

void draw_scale_bar(Canvas& canvas, const Layout& layout) {
  const double length = bar_length(layout);
  const double y = layout.height() - 0.4 * margin;
  const double x = 0.6 * margin;
  const double end = x + length * layout.scale();
  canvas.line({{x, y}, {end, y}}, ink, 3);
  for (const double at : {x, 0.5 * (x + end), end}) canvas.line({{at, y - 7}, {at, y}}, ink, 3);
  char text[32];
  std::snprintf(text, sizeof text, "%g m", length);
  canvas.text({end + 12, y + 4}, text, 20, ink, Anchor::left);
}

void draw_axes(Canvas& canvas, const Layout& layout) {
  const Eigen::Vector2d at(layout.width() - 0.75 * margin, layout.height() - 0.55 * margin);
  for (const auto& [axis, name, color] :
       {std::tuple(Eigen::Vector2d(1, 0), "x", Color{200, 40, 40}), std::tuple(Eigen::Vector2d(0, 1), "y", Color{30, 140, 60})}) {
    const Eigen::Vector2d d = layout.direction(axis);
    canvas.line({at, at + 34 * d}, color, 2.5);
    canvas.text(at + 48 * d + Eigen::Vector2d(0, 6), name, 18, color, Anchor::middle);
  }
}

void draw_title(Canvas& canvas, const Layout& layout, const FloorPlan& plan) {
  const auto corridors =
      std::count_if(plan.places.begin(), plan.places.end(), [](const DrawnPlace& place) { return place.corridor && !place.name.empty(); });
  const auto rooms = std::count_if(plan.places.begin(), plan.places.end(), [](const DrawnPlace& place) { return !place.corridor; });
  double length = 0;
  for (std::size_t i = 1; i < plan.path.size(); ++i) length += (plan.path[i] - plan.path[i - 1]).norm();
  char text[128];
  char doors[32] = "";
  if (!plan.doors.empty()) std::snprintf(doors, sizeof doors, ", %zu door%s", plan.doors.size(), plan.doors.size() == 1 ? "" : "s");
  std::snprintf(text, sizeof text, "%td room%s, %td corridor%s%s, path %.1f m", rooms, rooms == 1 ? "" : "s", corridors, corridors == 1 ? "" : "s",
                doors, length);
  canvas.text({0.6 * margin, 0.5 * margin}, text, 24, ink, Anchor::left);
  if (plan.path.empty()) return;
  const double x = layout.width() - 0.6 * margin;
  canvas.text({x, 0.5 * margin}, "end", 20, ink, Anchor::right);
  canvas.disc({x - 58, 0.5 * margin - 6}, 7, end_ink);
  canvas.text({x - 80, 0.5 * margin}, "start", 20, ink, Anchor::right);
  canvas.disc({x - 148, 0.5 * margin - 6}, 7, start_ink);
}

std::string draw(const FloorPlan& plan, std::unique_ptr<Canvas> (*make)(int, int)) {
  const Layout layout(plan);
  const auto canvas = make(layout.width(), layout.height());
  draw_cells(*canvas, layout, plan.free, plan.cell, free_fill);
  std::size_t room = 0;
  for (const DrawnPlace& place : plan.places) {
    if (place.part) continue;
    std::vector<Canvas::Points> loops{on_page(layout, place.outline)};
    for (const auto& hole : place.holes) loops.push_back(on_page(layout, hole));
    canvas->fill_without_holes(loops, place.corridor ? corridor_fill : room_fills[room++ % std::size(room_fills)]);
    for (Canvas::Points& loop : loops) {
      if (loop.empty()) continue;
      loop.push_back(loop.front());
      canvas->line(loop, outline_ink, 1.2);
    }
  }
  draw_cells(*canvas, layout, plan.obstacles, plan.cell, obstacle_ink);
  draw_walls(*canvas, layout, plan);
  draw_doors(*canvas, layout, plan);
  draw_path(*canvas, layout, plan);
  for (const DrawnPlace& place : plan.places) draw_label(*canvas, layout, place);
  draw_title(*canvas, layout, plan);
  draw_scale_bar(*canvas, layout);
  draw_axes(*canvas, layout);
  return canvas->bytes();
}

}  // namespace

std::string floor_plan_svg(const FloorPlan& plan) { return draw(plan, svg_canvas); }

std::string floor_plan_png(const FloorPlan& plan) { return draw(plan, png_canvas); }

}  // namespace sgraph
