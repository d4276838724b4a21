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

// The point of a wall at `along` its centre line, `across` to the left and `up` from its bottom, with the wall's lean and bow.
Eigen::Vector3d on_wall(const Wall& wall, double along, double across, double up) {
  const Eigen::Vector2d direction = wall.direction();
  const double share = 2 * along / wall.length() - 1;
  const double left = across + wall.lean * (up - 0.5 * wall.height) + wall.bow * std::max(0.0, 1 - share * share);
  const Eigen::Vector2d p = wall.p + along * direction + left * Eigen::Vector2d(-direction.y(), direction.x());
  return {p.x(), p.y(), wall.bottom + up};
}

// Cuts an interval of a bowed wall into pieces that are straight to a tenth of a millimetre.
std::vector<std::pair<double, double>> straight_pieces(const Wall& wall, double begin, double end) {
  const int count =
      wall.bow == 0 ? 1 : std::max(1, static_cast<int>(std::ceil((end - begin) / wall.length() * std::sqrt(std::abs(wall.bow) / 1e-4))));
  std::vector<std::pair<double, double>> pieces;
  for (int i = 0; i < count; ++i) pieces.emplace_back(begin + (end - begin) * i / count, begin + (end - begin) * (i + 1) / count);
  return pieces;
}

void add_pane(std::vector<Surface>& all, const Wall& wall, const WallPiece& piece) {
  for (const auto& [begin, end] : straight_pieces(wall, piece.begin, piece.end)) {
    all.push_back({{on_wall(wall, begin, 0, piece.bottom), on_wall(wall, end, 0, piece.bottom), on_wall(wall, end, 0, piece.top),
                    on_wall(wall, begin, 0, piece.top)},
                   SurfaceKind::glass,
                   Material::glass});
  }
}

// How far a wall's body goes into floor and ceiling, so that uneven ones leave no gap [m].
struct Margin {
  double below = 0;
  double above = 0;
};

// Of a body that reaches from floor to ceiling along a line. Into a storey that follows without a slab it goes no further than unevenness asks for,
// or it would stand there as a kerb.
Margin margin_of(const World& world, const Storey& storey, const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  if (storey.floor_shape.flat() && storey.ceiling_shape.flat()) return {};
  constexpr double deep = 0.05;
  constexpr double spacing = 0.25;  // the waves are metres long
  constexpr double closed = 0.001;
  Margin tight{-deep, -deep};
  const int steps = static_cast<int>((q - p).norm() / spacing) + 1;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d at = p + static_cast<double>(i) / steps * (q - p);
    tight.below = std::max(tight.below, closed - storey.floor_shape(at));
    tight.above = std::max(tight.above, closed + storey.ceiling_shape(at));
  }
  const auto any = [&](auto&& touches) { return std::any_of(world.storeys.begin(), world.storeys.end(), touches); };
  return {any([&](const Storey& other) { return stands_on(storey, other); }) ? tight.below : deep,
          any([&](const Storey& other) { return stands_on(other, storey); }) ? tight.above : deep};
}

// A piece of a wall's body, closed on all sides but, where it stands on the floor, at its bottom.
void add_body(std::vector<Surface>& all, const Wall& wall, WallPiece piece, const Margin& margin) {
  const double half = 0.5 * wall.thickness;
  const bool on_floor = piece.bottom <= 0;
  if (on_floor) piece.bottom -= margin.below;
  if (piece.top >= wall.height) piece.top += margin.above;
  const auto upright = [&](double along_a, double across_a, double along_b, double across_b) {
    all.push_back({{on_wall(wall, along_a, across_a, piece.bottom), on_wall(wall, along_b, across_b, piece.bottom),
                    on_wall(wall, along_b, across_b, piece.top), on_wall(wall, along_a, across_a, piece.top)},
                   SurfaceKind::wall,
                   wall.material});
  };
  const auto lid = [&](double begin, double end, double up) {
    all.push_back({{on_wall(wall, begin, -half, up), on_wall(wall, end, -half, up), on_wall(wall, end, half, up), on_wall(wall, begin, half, up)},
                   SurfaceKind::wall,
                   wall.material});
  };
  const auto straight = straight_pieces(wall, piece.begin, piece.end);
  for (const auto& [begin, end] : straight) upright(begin, -half, end, -half);
  upright(piece.end, -half, piece.end, half);
  for (const auto& [begin, end] : straight) upright(end, half, begin, half);
  upright(piece.begin, half, piece.begin, -half);
  for (const auto& [begin, end] : straight) {
    if (!on_floor) lid(begin, end, piece.bottom);
    lid(begin, end, piece.top);
  }
}

void add_wall(std::vector<Surface>& all, const Wall& wall, const Margin& margin) {
  for (const WallPiece& piece : pieces_of(wall, false)) {
    if (wall.glass) {
      add_pane(all, wall, piece);
    } else {
      add_body(all, wall, piece, margin);
    }
  }
  if (wall.glass) return;
  for (const Opening& opening : wall.openings) {
    if (opening.pane) add_pane(all, wall, {opening.begin, opening.end, opening.bottom, opening.top});
  }
}

// The part of a polygon on one side of an axis-parallel line.
std::vector<Eigen::Vector2d> cut(const std::vector<Eigen::Vector2d>& polygon, int axis, double at, double sign) {
  std::vector<Eigen::Vector2d> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - at);
    const double db = sign * (b[axis] - at);
    if (da >= 0) kept.push_back(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) kept.push_back(a + (b - a) * (da / (da - db)));
  }
  return kept;
}

// What rectangles leave of an outline, in pieces.
std::vector<std::vector<Eigen::Vector2d>> without(const std::vector<Eigen::Vector2d>& outline,
                                                  const std::vector<std::vector<Eigen::Vector2d>>& voids) {
  std::vector<std::vector<Eigen::Vector2d>> pieces{outline};
  for (const auto& corners : voids) {
    const Eigen::Vector2d& low = corners[0];
    const Eigen::Vector2d& high = corners[1];
    std::vector<std::vector<Eigen::Vector2d>> left;
    for (const auto& piece : pieces) {
      const auto middle = cut(cut(piece, 0, low.x(), 1), 0, high.x(), -1);
      for (const auto& part : {cut(piece, 0, low.x(), -1), cut(piece, 0, high.x(), 1), cut(middle, 1, low.y(), -1), cut(middle, 1, high.y(), 1)}) {
        if (part.size() >= 3) left.push_back(part);
      }
    }
    pieces = left;
  }
  return pieces;
}

// A floor or ceiling: the outline, or where it isn't flat, triangles over cells of half a metre.
void add_level(std::vector<Surface>& all, const std::vector<Eigen::Vector2d>& outline, double z, const Unevenness& shape, SurfaceKind kind,
               Material material) {
  constexpr double cell = 0.5;
  if (shape.flat()) {
    all.push_back({at_height(outline, z), kind, material});
    return;
  }
  Eigen::Vector2d low = outline.front();
  Eigen::Vector2d high = outline.front();
  for (const Eigen::Vector2d& p : outline) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const auto lifted = [&](const Eigen::Vector2d& p) { return Eigen::Vector3d(p.x(), p.y(), z + shape(p)); };
  for (double x = low.x(); x < high.x(); x += cell) {
    const std::vector<Eigen::Vector2d> strip = cut(cut(outline, 0, x, 1), 0, x + cell, -1);
    if (strip.size() < 3) continue;
    for (double y = low.y(); y < high.y(); y += cell) {
      const std::vector<Eigen::Vector2d> piece = cut(cut(strip, 1, y, 1), 1, y + cell, -1);
      for (std::size_t i = 1; i + 1 < piece.size(); ++i) {  // a fan: exact for convex pieces, and within the cell for others
        const Eigen::Vector2d u = piece[i] - piece[0];
        const Eigen::Vector2d v = piece[i + 1] - piece[0];
        if (std::abs(u.x() * v.y() - u.y() * v.x()) > 1e-9)
          all.push_back({{lifted(piece[0]), lifted(piece[i]), lifted(piece[i + 1])}, kind, material});
      }
    }
  }
}

// The top of a ramp and, a little lower, its underside.
void add_ramp(std::vector<Surface>& all, const Flight& flight) {
  constexpr double slab = 0.3;
  const Eigen::Vector3d way = (flight.end - flight.begin).normalized();
  const Eigen::Vector3d across = 0.5 * flight.width * Eigen::Vector3d(-way.y(), way.x(), 0).normalized();
  for (const double down : {0.0, slab}) {
    const Eigen::Vector3d low = flight.begin - Eigen::Vector3d(0, 0, down);
    const Eigen::Vector3d high = flight.end - Eigen::Vector3d(0, 0, down);
    all.push_back({{low - across, high - across, high + across, low + across}, SurfaceKind::stairs, Material::concrete});
  }
}

void add_ground(std::vector<Surface>& all, const World& world) {
  constexpr double margin = 60;
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (const Storey& storey : world.storeys) {
    for (const auto& outline : storey.outlines) {
      for (const Eigen::Vector2d& p : outline) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
  }
  low.array() -= margin;
  high.array() += margin;
  all.push_back({at_height({low, {high.x(), low.y()}, high, {low.x(), high.y()}}, ground_height(world)), SurfaceKind::ground, Material::ground});
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
    case SurfaceKind::stairs: return "stairs";
  }
  return "?";
}

std::vector<Block> stairs_of(const World& world, bool ramps) {
  constexpr double slab = 0.3;       // a step's thickness
  constexpr double low_step = 0.02;  // of a ramp
  std::vector<Block> blocks;
  for (const Flight& flight : world.flights) {
    if (flight.step == 0 && !ramps) continue;
    const Eigen::Vector2d way = (flight.end - flight.begin).head<2>();
    const double rise = flight.end.z() - flight.begin.z();
    const int count = std::max(1, static_cast<int>(std::lround(rise / (flight.step > 0 ? flight.step : low_step))));
    for (int i = 0; i < count; ++i) {
      Block step;
      step.name = "stairs";
      step.material = Material::concrete;
      step.size = {way.norm() / count, flight.width, slab};
      step.yaw = std::atan2(way.y(), way.x());
      const Eigen::Vector2d middle = flight.begin.head<2>() + way * ((i + 0.5) / count);
      step.center = {middle.x(), middle.y(), flight.begin.z() + rise * (i + 1) / count - 0.5 * slab};
      blocks.push_back(step);
    }
  }
  for (const Landing& landing : world.landings) {
    Block block;
    block.name = "landing";
    block.material = Material::concrete;
    const Eigen::Vector2d middle = 0.5 * (landing.low + landing.high);
    block.center = {middle.x(), middle.y(), landing.z - 0.5 * slab};
    block.size = {landing.high.x() - landing.low.x(), landing.high.y() - landing.low.y(), slab};
    blocks.push_back(block);
  }
  return blocks;
}

double ground_height(const World& world) {
  constexpr double step = 0.15;  // down from the lowest floor
  double lowest = 1e9;
  for (const Storey& storey : world.storeys) lowest = std::min(lowest, storey.elevation);
  return lowest - step;
}

std::vector<Surface> surfaces_of(const World& world) {
  std::vector<Surface> all;
  int objects = 0;
  std::size_t numbered = 0;
  const auto end_object = [&] {
    for (; numbered < all.size(); ++numbered) all[numbered].object = objects;
    ++objects;
  };
  for (const Storey& storey : world.storeys) {
    for (const auto& outline : storey.outlines) {
      if (storey.floor) {
        for (const auto& piece : without(outline, storey.floor_voids))
          add_level(all, piece, storey.elevation, storey.floor_shape, SurfaceKind::floor, Material::concrete);
      }
      end_object();
      if (storey.ceiling) {
        for (const auto& piece : without(outline, storey.ceiling_voids))
          add_level(all, piece, storey.elevation + storey.height, storey.ceiling_shape, SurfaceKind::ceiling, Material::plaster);
      }
      end_object();
    }
    const auto reaches_ceiling = [&storey](double top) { return top > storey.elevation + storey.height - 0.01; };
    for (const Wall& wall : storey.walls) {
      const Margin margin = margin_of(world, storey, wall.p, wall.q);
      add_wall(all, wall, {margin.below, reaches_ceiling(wall.bottom + wall.height) ? margin.above : 0});
      end_object();
    }
    for (const Block& column : storey.columns) {
      const double half = 0.5 * column.size.z();
      const Margin margin = margin_of(world, storey, column.center.head<2>(), column.center.head<2>());
      add_prism(all, footprint(column), column.center.z() - half - margin.below,
                column.center.z() + half + (reaches_ceiling(column.center.z() + half) ? margin.above : 0), SurfaceKind::column, column.material,
                false, true);
      end_object();
    }
    for (const Block& piece : storey.furniture) {
      const double half = 0.5 * piece.size.z();
      const double bottom = piece.center.z() - half;
      add_prism(all, footprint(piece), bottom, piece.center.z() + half, SurfaceKind::furniture, piece.material,
                bottom > storey.elevation + storey.floor_shape(piece.center.head<2>()) + 1e-3, true);
      end_object();
    }
  }
  for (const Block& step : stairs_of(world, false)) {
    const double half = 0.5 * step.size.z();
    add_prism(all, footprint(step), step.center.z() - half, step.center.z() + half, SurfaceKind::stairs, step.material, true, true);
  }
  for (const Flight& flight : world.flights) {
    if (flight.step == 0) add_ramp(all, flight);
  }
  end_object();
  if (world.ground) add_ground(all, world);
  end_object();
  return all;
}

}  // namespace sgraph::sim
