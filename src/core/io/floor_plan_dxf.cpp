#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sgraph_slam/core/io/floor_plan.hpp"

namespace sgraph {
namespace {

constexpr double usual_thickness = 0.15;  // of a wall of which one face is known [m]
constexpr double thickest = 0.6;          // [m]
constexpr double parallel = 0.995;        // cosine between the faces of one wall

// A group of DXF: a code and its value, a line each.
class Dxf {
 public:
  void text(int code, const std::string& value) { bytes_ += std::to_string(code) + '\n' + value + '\n'; }
  void number(int code, double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.4f", value);
    text(code, buffer);
  }
  void point(const Eigen::Vector2d& p, int offset = 0) {
    number(10 + offset, p.x());
    number(20 + offset, p.y());
    number(30 + offset, 0);
  }
  void entity(const char* type, const char* layer) {
    text(0, type);
    text(8, layer);
  }
  void line(const char* layer, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    entity("LINE", layer);
    point(a);
    point(b, 1);
  }
  void outline(const char* layer, const std::vector<Eigen::Vector2d>& corners) {
    entity("POLYLINE", layer);
    text(66, "1");
    point(Eigen::Vector2d::Zero());
    text(70, "1");  // closed
    for (const Eigen::Vector2d& corner : corners) {
      entity("VERTEX", layer);
      point(corner);
    }
    entity("SEQEND", layer);
  }
  void label(const char* layer, const Eigen::Vector2d& at, double height, const std::string& words) {
    entity("TEXT", layer);
    point(at);
    number(40, height);
    text(1, words);
    text(72, "1");  // centred on the second point
    point(at, 1);
  }
  void layer(const char* name, int color) {
    text(0, "LAYER");
    text(2, name);
    text(70, "0");
    text(62, std::to_string(color));
    text(6, "CONTINUOUS");
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

// The other face of the wall behind a piece of a face: how far off it is; the usual thickness when it hasn't been seen. A piece's back is on its
// right.
double thickness_behind(const FloorPlan& plan, const Segment2d& piece) {
  const Eigen::Vector2d u = (piece.second - piece.first).normalized();
  const Eigen::Vector2d middle = 0.5 * (piece.first + piece.second);
  double least = thickest;
  bool found = false;
  for (const DrawnWall& other : plan.walls) {
    const Eigen::Vector2d v = (other.line.second - other.line.first).normalized();
    if (u.dot(v) > -parallel) continue;  // faces of one wall look away from each other
    const double depth = left_of(u).dot(other.line.first - middle);
    const double along = v.dot(middle - other.line.first);
    if (depth <= 0.02 || depth >= least || along < 0 || along > (other.line.second - other.line.first).norm()) continue;
    least = depth;
    found = true;
  }
  return found ? least : usual_thickness;
}

// Whether a point lies well inside a place, not on its outline: furniture, columns, screens.
bool inside_a_place(const FloorPlan& plan, const Eigen::Vector2d& p) {
  constexpr double beside_outline = 0.15;  // [m]
  for (const DrawnPlace& place : plan.places) {
    bool inside = false;
    double least = HUGE_VAL;
    const auto look_at = [&](const std::vector<Eigen::Vector2d>& loop) {
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const Eigen::Vector2d& a = loop[i];
        const Eigen::Vector2d& b = loop[(i + 1) % loop.size()];
        if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
        const double length2 = (b - a).squaredNorm();
        const double t = length2 > 0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0;
        least = std::min(least, (p - a - t * (b - a)).norm());
      }
    };
    if (place.part) continue;
    look_at(place.outline);
    for (const auto& hole : place.holes) look_at(hole);
    if (inside && least > beside_outline) return true;
  }
  return false;
}

std::string fixed(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.2f", value);
  return buffer;
}

void add_walls(const FloorPlan& plan, Dxf& dxf) {
  for (const DrawnWall& wall : plan.walls) {
    if (wall.low) continue;
    for (const Segment2d& piece : wall.solid) {
      if ((piece.second - piece.first).norm() < 1e-6) continue;
      if (inside_a_place(plan, 0.5 * (piece.first + piece.second))) {
        dxf.line("INSIDE", piece.first, piece.second);
        continue;
      }
      const Eigen::Vector2d back = thickness_behind(plan, piece) * left_of((piece.second - piece.first).normalized());
      dxf.line("WALLS", piece.first, piece.second);
      dxf.line("WALLS", piece.first, piece.first + back);
      dxf.line("WALLS", piece.second, piece.second + back);
    }
  }
}

void add_doors(const FloorPlan& plan, Dxf& dxf) {
  for (const DrawnDoor& door : plan.doors) {
    const Eigen::Vector2d through(std::cos(door.yaw), std::sin(door.yaw));
    const Eigen::Vector2d along = left_of(through);
    const Eigen::Vector2d hinge = door.center - 0.5 * door.width * along;
    dxf.line("DOORS", hinge, hinge + door.width * along);
    dxf.line("DOORS", hinge, hinge + door.width * through);
    dxf.entity("ARC", "DOORS");
    dxf.point(hinge);
    dxf.number(40, door.width);
    const double start = door.yaw * 180 / M_PI;
    dxf.number(50, start < 0 ? start + 360 : start);
    dxf.number(51, start + 90 < 0 ? start + 450 : start + 90);
    dxf.label("LABELS", door.center - 0.3 * through, 0.12, fixed(door.width));
  }
}

void add_places(const FloorPlan& plan, Dxf& dxf) {
  for (const DrawnPlace& place : plan.places) {
    if (!place.part) {
      dxf.outline("PLACES", place.outline);
      for (const auto& hole : place.holes) dxf.outline("PLACES", hole);
    }
    if (place.name.empty()) continue;
    dxf.label("LABELS", place.center + Eigen::Vector2d(0, 0.15), 0.3, place.name);
    std::string size = fixed(place.area) + " m2";
    if (place.size.x() > 0) size += ", " + fixed(place.size.x()) + " x " + fixed(place.size.y()) + " m";
    dxf.label("LABELS", place.center - Eigen::Vector2d(0, 0.25), 0.2, size);
  }
}

}  // namespace

std::string floor_plan_dxf(const FloorPlan& plan) {
  Dxf dxf;
  dxf.text(0, "SECTION");
  dxf.text(2, "HEADER");
  dxf.text(9, "$ACADVER");
  dxf.text(1, "AC1009");
  dxf.text(9, "$INSUNITS");
  dxf.text(70, "6");  // metres
  dxf.text(0, "ENDSEC");
  dxf.text(0, "SECTION");
  dxf.text(2, "TABLES");
  dxf.text(0, "TABLE");
  dxf.text(2, "LAYER");
  dxf.text(70, "5");
  dxf.layer("WALLS", 7);
  dxf.layer("INSIDE", 8);
  dxf.layer("DOORS", 30);
  dxf.layer("PLACES", 5);
  dxf.layer("LABELS", 3);
  dxf.text(0, "ENDTAB");
  dxf.text(0, "ENDSEC");
  dxf.text(0, "SECTION");
  dxf.text(2, "ENTITIES");
  add_walls(plan, dxf);
  add_doors(plan, dxf);
  add_places(plan, dxf);
  dxf.text(0, "ENDSEC");
  dxf.text(0, "EOF");
  return dxf.bytes();
}

}  // namespace sgraph
