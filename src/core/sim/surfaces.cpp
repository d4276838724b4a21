#include <algorithm>
#include <cmath>

#include "plan.hpp"
#include "sgraph_slam/core/sim/scene.hpp"

namespace sgraph::sim {

namespace {

using Outline = std::vector<Eigen::Vector3d>;

Outline at_height(const std::vector<Eigen::Vector2d>& plan, double z) {
  Outline outline;
  for (const Eigen::Vector2d& p : plan) outline.emplace_back(p.x(), p.y(), z);
  return outline;
}

// An upright prism over a plan outline; without the faces named false.
void add_prism(std::vector<Surface>& all, const std::vector<Eigen::Vector2d>& plan, double bottom, double top, SurfaceKind kind, Material material,
               bool with_bottom, bool with_top) {
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Eigen::Vector2d& a = plan[i];
    const Eigen::Vector2d& b = plan[(i + 1) % plan.size()];
    all.push_back({{{a.x(), a.y(), bottom}, {b.x(), b.y(), bottom}, {b.x(), b.y(), top}, {a.x(), a.y(), top}}, kind, material});
  }
  if (with_bottom) all.push_back({at_height(plan, bottom), kind, material});
  if (with_top) all.push_back({at_height(plan, top), kind, material});
}

void add_pane(std::vector<Surface>& all, const Wall& wall, double begin, double end, double bottom, double top) {
  const Eigen::Vector2d a = wall.p + begin * wall.direction();
  const Eigen::Vector2d b = wall.p + end * wall.direction();
  const double low = wall.bottom + bottom;
  const double high = wall.bottom + top;
  all.push_back({{{a.x(), a.y(), low}, {b.x(), b.y(), low}, {b.x(), b.y(), high}, {a.x(), a.y(), high}}, SurfaceKind::glass, Material::glass});
}

void add_wall(std::vector<Surface>& all, const Wall& wall) {
  if (wall.glass) {
    for (const WallPiece& piece : pieces_of(wall, false)) add_pane(all, wall, piece.begin, piece.end, piece.bottom, piece.top);
    return;
  }
  const Eigen::Vector2d along = wall.direction();
  const Eigen::Vector2d across = 0.5 * wall.thickness * Eigen::Vector2d(-along.y(), along.x());
  for (const WallPiece& piece : pieces_of(wall, false)) {
    const Eigen::Vector2d a = wall.p + piece.begin * along;
    const Eigen::Vector2d b = wall.p + piece.end * along;
    add_prism(all, {a - across, b - across, b + across, a + across}, wall.bottom + piece.bottom, wall.bottom + piece.top, SurfaceKind::wall,
              wall.material, piece.bottom > 0, true);
  }
  for (const Opening& opening : wall.openings) {
    if (opening.pane) add_pane(all, wall, opening.begin, opening.end, opening.bottom, opening.top);
  }
}

void add_ground(std::vector<Surface>& all, const World& world) {
  constexpr double margin = 60;
  double lowest = 1e9;
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (const Storey& storey : world.storeys) {
    lowest = std::min(lowest, storey.elevation);
    for (const auto& outline : storey.outlines) {
      for (const Eigen::Vector2d& p : outline) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
  }
  low.array() -= margin;
  high.array() += margin;
  all.push_back({at_height({low, {high.x(), low.y()}, high, {low.x(), high.y()}}, lowest - 0.15), SurfaceKind::ground, Material::ground});
}

}  // namespace

const char* to_string(SurfaceKind value) {
  switch (value) {
    case SurfaceKind::wall: return "wall";
    case SurfaceKind::floor: return "floor";
    case SurfaceKind::ceiling: return "ceiling";
    case SurfaceKind::column: return "column";
    case SurfaceKind::furniture: return "furniture";
    case SurfaceKind::glass: return "glass";
    case SurfaceKind::ground: return "ground";
  }
  return "?";
}

std::vector<Surface> surfaces_of(const World& world) {
  std::vector<Surface> all;
  for (const Storey& storey : world.storeys) {
    for (const auto& outline : storey.outlines) {
      if (storey.floor) all.push_back({at_height(outline, storey.elevation), SurfaceKind::floor, Material::concrete});
      if (storey.ceiling) all.push_back({at_height(outline, storey.elevation + storey.height), SurfaceKind::ceiling, Material::plaster});
    }
    for (const Wall& wall : storey.walls) add_wall(all, wall);
    for (const Block& column : storey.columns) {
      const double half = 0.5 * column.size.z();
      add_prism(all, footprint(column), column.center.z() - half, column.center.z() + half, SurfaceKind::column, column.material, false, true);
    }
    for (const Block& piece : storey.furniture) {
      const double half = 0.5 * piece.size.z();
      const double bottom = piece.center.z() - half;
      add_prism(all, footprint(piece), bottom, piece.center.z() + half, SurfaceKind::furniture, piece.material, bottom > storey.elevation + 1e-3,
                true);
    }
  }
  if (world.ground) add_ground(all, world);
  return all;
}

}  // namespace sgraph::sim
