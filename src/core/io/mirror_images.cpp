#include "sgraph_slam/core/io/mirror_images.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "ray_origins.hpp"
#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/math/walk_cells.hpp"
#include "voxel_key.hpp"

namespace sgraph {
namespace {

constexpr double voxel = 0.1;             // in which points count as seen [m]
constexpr double cell = 0.1;              // of the raster on a wall [m]
constexpr double on_wall = 0.06;          // of a wall's face: its noise [m]
constexpr double behind = 0.1;            // a wall's face, and no nearer, a point is seen through it [m]
constexpr double least_length = 1.0;      // of a wall, each way: anything smaller is furniture [m]
constexpr double reach = 30;              // of the LiDAR before a wall [m]
constexpr double sill = 0.35;             // a hole that begins higher above the floor is no passage [m]
constexpr int least_rays = 3;             // through a cell, for a hole
constexpr std::size_t least_images = 40;  // points through a hole, to judge it
constexpr double pane_returns = 0.15;     // of the cells of a hole, with points on the wall: it is glass
constexpr double mirrored_share = 0.3;    // of the points behind a window that have something at their image
constexpr double mirrored_door = 0.45;    // the same of a hole that reaches the floor: a room may look like the one before the door
constexpr int depths = 7;                 // of a pane behind the wall's face that are tried: up to 0.3 m, half of a thick wall
constexpr double depth_step = 0.05;       // between them [m]
constexpr double across = 0.3;            // most cosine between the normals of a wall and of a surface that goes on as its own image
constexpr double on_surface = 0.1;        // [m]: what a plane's estimate and the mirror's depth may be off
constexpr double pass_cell = 0.2;         // of the raster in which rays count that go on [m]
constexpr double goes_on = 0.3;           // deeper behind the wall than what they passed, such rays end [m]
constexpr double clearance = 0.4;         // and so much farther along [m]
constexpr std::uint8_t least_passes = 6;  // rays; a few may slip past an edge
constexpr double most_pass_cells = 20e6;
constexpr std::size_t most_samples = 2000;  // of the points seen through a hole
constexpr double farthest = 5e4;            // of a point that a voxel's number can tell [m]
constexpr int most_cells = 4'000'000;       // of one wall's raster

std::uint64_t key_of(const Eigen::Vector3d& p) { return voxel_key(p.array() / voxel); }

// Voxels in which something was seen.
class Seen {
 public:
  void add(const Eigen::Vector3d& p) {
    keys_.push_back(key_of(p));
    if (keys_.size() > 2 * settled_ + 1'000'000) settle();
  }
  void settle() {
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    settled_ = keys_.size();
  }
  // In the voxel or one that the point is nearest to. Settled before.
  [[nodiscard]] bool near(const Eigen::Vector3d& p) const {
    const Eigen::Array3d at = p.array() / voxel - 0.5;
    for (int k = 0; k < 8; ++k) {
      if (std::binary_search(keys_.begin(), keys_.end(), voxel_key(at + Eigen::Array3d(k & 1, k >> 1 & 1, k >> 2)))) return true;
    }
    return false;
  }

 private:
  std::vector<std::uint64_t> keys_;
  std::size_t settled_ = 0;
};

// A wall's face with a raster over its outline.
struct Wall {
  Plane plane;
  Eigen::Vector3d along, up;
  Eigen::Vector2d corner;  // of the raster, along and up [m]
  int columns = 0, rows = 0;
  double floor = std::numeric_limits<double>::infinity();  // lowest z beside it
  Eigen::AlignedBox3d box;
  std::vector<char> inside;
  std::vector<std::uint16_t> passes;  // rays through a cell
  std::vector<std::uint8_t> returns;  // bit k: something was seen where a pane would be k steps behind the face
  std::vector<int> hole;              // number of the hole that a cell belongs to; -1: none

  [[nodiscard]] std::optional<std::uint32_t> cell_at(const Eigen::Vector3d& p) const {
    const double column = (along.dot(p) - corner.x()) / cell;
    const double row = (up.dot(p) - corner.y()) / cell;
    if (!(column >= 0 && row >= 0 && column < columns && row < rows)) return std::nullopt;
    const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
    if (inside[i] == 0) return std::nullopt;
    return static_cast<std::uint32_t>(i);
  }
};

std::optional<Wall> wall_of(const ScenePlane& plane) {
  if (std::abs(plane.plane.normal.z()) > 0.2 || plane.extent.size() < 3) return std::nullopt;
  Wall wall;
  wall.plane = plane.plane;
  wall.along = Eigen::Vector3d::UnitZ().cross(plane.plane.normal).normalized();
  wall.up = plane.plane.normal.cross(wall.along);
  Eigen::AlignedBox2d box;
  std::vector<Eigen::Vector2d> outline;
  for (const Eigen::Vector3d& p : plane.extent) {
    outline.emplace_back(wall.along.dot(p), wall.up.dot(p));
    wall.box.extend(p);
    box.extend(outline.back());
  }
  if (!(box.sizes().minCoeff() >= least_length) || box.volume() / (cell * cell) > most_cells) return std::nullopt;
  wall.corner = box.min();
  wall.columns = static_cast<int>(box.sizes().x() / cell) + 1;
  wall.rows = static_cast<int>(box.sizes().y() / cell) + 1;
  const std::size_t count = static_cast<std::size_t>(wall.columns) * static_cast<std::size_t>(wall.rows);
  wall.inside.assign(count, 0);
  wall.passes.assign(count, 0);
  wall.returns.assign(count, 0);
  wall.hole.assign(count, -1);
  double turn = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    turn += a.x() * b.y() - a.y() * b.x();
  }
  for (int row = 0; row < wall.rows; ++row) {
    for (int column = 0; column < wall.columns; ++column) {
      const Eigen::Vector2d at = wall.corner + cell * Eigen::Vector2d(column + 0.5, row + 0.5);
      bool in = true;
      for (std::size_t i = 0; i < outline.size() && in; ++i) {
        const Eigen::Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
        const Eigen::Vector2d to = at - outline[i];
        in = (edge.x() * to.y() - edge.y() * to.x()) * turn >= 0;
      }
      wall.inside[static_cast<std::size_t>(row) * static_cast<std::size_t>(wall.columns) + static_cast<std::size_t>(column)] = in ? 1 : 0;
    }
  }
  return wall;
}

struct Hole {
  std::uint32_t wall = 0;
  std::vector<std::uint32_t> cells{};
  bool reaches_floor = true;
  int depth = 0;  // of the mirror behind the wall's face, in steps
  bool mirrors = false;
  bool glimmers = false;                  // shows what is there, and images before it
  std::vector<Eigen::Vector3f> beyond{};  // points seen through it, every `stride`-th
  std::size_t stride = 1;
  std::size_t count = 0;

  void sample(const Eigen::Vector3d& p) {
    if (count++ % stride != 0) return;
    beyond.push_back(p.cast<float>());
    if (beyond.size() < 2 * most_samples) return;
    for (std::size_t i = 0; i < most_samples; ++i) beyond[i] = beyond[2 * i];
    beyond.resize(most_samples);
    stride *= 2;
  }
};

// Cells that rays pass, side by side.
std::vector<Hole> holes_of(std::vector<Wall>& walls) {
  std::vector<Hole> holes;
  for (std::uint32_t w = 0; w < walls.size(); ++w) {
    Wall& wall = walls[w];
    for (std::uint32_t first = 0; first < wall.hole.size(); ++first) {
      if (wall.passes[first] < least_rays || wall.hole[first] >= 0) continue;
      Hole hole;
      hole.wall = w;
      hole.cells.push_back(first);
      wall.hole[first] = static_cast<int>(holes.size());
      for (std::size_t k = 0; k < hole.cells.size(); ++k) {
        const int column = static_cast<int>(hole.cells[k]) % wall.columns;
        const int row = static_cast<int>(hole.cells[k]) / wall.columns;
        for (int r = std::max(0, row - 1); r <= std::min(wall.rows - 1, row + 1); ++r) {
          for (int c = std::max(0, column - 1); c <= std::min(wall.columns - 1, column + 1); ++c) {
            const auto i = static_cast<std::uint32_t>(r * wall.columns + c);
            if (wall.passes[i] < least_rays || wall.hole[i] >= 0) continue;
            wall.hole[i] = static_cast<int>(holes.size());
            hole.cells.push_back(i);
          }
        }
      }
      int lowest = wall.rows;
      for (const std::uint32_t i : hole.cells) {
        lowest = std::min(lowest, static_cast<int>(i) / wall.columns);
      }
      const double bottom = (wall.corner.y() + cell * lowest) / std::max(0.5, wall.up.z());
      hole.reaches_floor = bottom - wall.floor < sill;
      holes.push_back(std::move(hole));
    }
  }
  return holes;
}

// Where a ray meets a wall.
struct Meeting {
  std::uint32_t wall;
  std::uint32_t cell;
};

// A point, map frame, and the walls that its ray passes or ends on.
struct Sight {
  Eigen::Vector3d eye;
  Eigen::Vector3d p;
  std::vector<Meeting> through;
  std::vector<Meeting> on;
};

// The walls that a keyframe may see, by the direction in which they lie: a ray meets few of a building's walls.
class WallsAround {
 public:
  // `moved`: how far from `center` the rays begin [m].
  WallsAround(const std::vector<Wall>& walls, const Eigen::Vector3d& center, double moved) : center_(center.head<2>()) {
    for (std::uint32_t w = 0; w < walls.size(); ++w) {
      if (walls[w].plane.distance(center) <= behind || walls[w].box.exteriorDistance(center) >= reach) continue;
      const Wall& wall = walls[w];
      // Its ends on the ground as seen from here, and how far beside them a ray that begins elsewhere may pass the same place.
      const double length = cell * wall.columns;
      const Eigen::Vector2d along = wall.along.head<2>().normalized();
      const Eigen::Vector2d normal = wall.plane.normal.head<2>().normalized();
      const double first = wall.corner.x() - along.dot(center_);
      const double distance = wall.plane.normal.dot(center) + wall.plane.d;
      const double nearest = std::hypot(distance, std::max({0.0, first, -first - length}));
      const double margin = moved + on_wall + std::abs(wall.plane.normal.z()) * wall.box.sizes().z();
      if (nearest <= 1.5 * margin) {  // all around
        for (std::vector<std::uint32_t>& sector : sectors_) sector.push_back(w);
        continue;
      }
      const double turn = std::asin(margin / nearest);
      const auto direction = [&](double at, double by) { return Eigen::Rotation2Dd(by) * (at * along - distance * normal); };
      // Seen from before it, a wall's axis runs from its first column, on the right or on the left.
      const double side = along.x() * normal.y() - along.y() * normal.x() > 0 ? 1 : -1;
      const int from = sector_of(direction(side > 0 ? first : first + length, -turn));
      const int to = sector_of(direction(side > 0 ? first + length : first, turn));
      for (int k = from;; k = (k + 1) % sectors) {
        sectors_[static_cast<std::size_t>(k)].push_back(w);
        if (k == to) break;
      }
    }
  }

  [[nodiscard]] const std::vector<std::uint32_t>& towards(const Eigen::Vector3d& p) const {
    return sectors_[static_cast<std::size_t>(sector_of(p.head<2>() - center_))];
  }

 private:
  static constexpr int sectors = 256;
  static constexpr double of_quarter = sectors / 4.0;

  // Grows with the angle from -pi; not evenly, but without an arcus tangent.
  static int sector_of(const Eigen::Vector2d& v) {
    const double sum = std::abs(v.x()) + std::abs(v.y());
    const double part = sum > 0 ? v.x() / sum : 1;  // 1 ahead, -1 behind
    const double around = v.y() < 0 ? part + 1 : 3 - part;
    return std::min(static_cast<int>(around * of_quarter), sectors - 1);
  }

  Eigen::Vector2d center_;
  std::array<std::vector<std::uint32_t>, sectors> sectors_;
};

// Calls `visit(sight)` with every point of every keyframe.
template <class Visit>
void visit_sights(const GraphSnapshot& snapshot, const Pose& T_base_lidar, const std::vector<Wall>& walls, const Visit& visit) {
  Sight sight;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const CloudPtr cloud = keyframe.cloud.get();
    if (!cloud) continue;
    const Pose T_map_lidar = keyframe.T_map_base * T_base_lidar;
    const RayOrigins origins(*cloud, T_map_lidar);
    const Eigen::Matrix3d rotation = T_map_lidar.matrix();
    double moved = 0;
    for (const Viewpoint& viewpoint : cloud->viewpoints) moved = std::max(moved, viewpoint.position.norm());
    const WallsAround around(walls, T_map_lidar.translation, moved);
    for (const Point& point : cloud->points) {
      if (!point.position().allFinite()) continue;
      sight.p = rotation * point.position().cast<double>() + T_map_lidar.translation;
      if (!(sight.p.cwiseAbs().maxCoeff() < farthest)) continue;
      sight.eye = origins.of(point);
      sight.through.clear();
      sight.on.clear();
      for (const std::uint32_t w : around.towards(sight.p)) {
        const Wall& wall = walls[w];
        const double s = wall.plane.distance(sight.p);
        if (s > on_wall) continue;
        if (s > -on_wall) {
          if (const auto i = wall.cell_at(sight.p)) sight.on.push_back({w, *i});
          continue;
        }
        if (s > -behind) continue;
        const double before = wall.plane.distance(sight.eye);
        if (before < behind) continue;
        if (const auto i = wall.cell_at(sight.eye + before / (before - s) * (sight.p - sight.eye))) sight.through.push_back({w, *i});
      }
      visit(sight);
    }
  }
}

// How low the floor lies beside each wall, by the keyframes near it; by the nearest one where none came near.
void find_floors(const GraphSnapshot& snapshot, const Pose& T_base_lidar, std::vector<Wall>& walls) {
  constexpr double near = 5;  // [m]
  std::vector<double> nearest(walls.size(), std::numeric_limits<double>::infinity());
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const Eigen::Vector3d at = (keyframe.T_map_base * T_base_lidar).translation;
    const auto floor = floor_below(snapshot, keyframe, T_base_lidar);
    if (!floor) continue;
    const double z = at.z() - floor->distance(at);
    for (std::size_t w = 0; w < walls.size(); ++w) {
      Wall& wall = walls[w];
      if (wall.plane.distance(at) <= 0) continue;
      const double distance = wall.box.exteriorDistance(at);
      if (distance < near) {
        wall.floor = nearest[w] < near ? std::min(wall.floor, z) : z;
        nearest[w] = std::min(nearest[w], distance);
      } else if (distance < nearest[w]) {
        wall.floor = z;
        nearest[w] = distance;
      }
    }
  }
}

// Where what stands at `p` would have to be seen before a mirror.
Eigen::Vector3d image_of(const Eigen::Vector3d& p, const Wall& wall, int depth) {
  return p - 2 * (wall.plane.distance(p) + depth_step * depth) * wall.plane.normal;
}

// Tells the surfaces that run across a wall, floor and ceiling among them: they go on behind it as their own images.
class Across {
 public:
  Across(const GraphSnapshot& snapshot, const Wall& wall, const Seen& seen) : along_(along_it * wall.plane.normal), seen_(seen) {
    for (const auto& [id, plane] : snapshot.planes) {
      if (std::abs(plane.plane.normal.dot(wall.plane.normal)) > across) continue;
      Eigen::AlignedBox3d box;
      for (const Eigen::Vector3d& corner : plane.extent) box.extend(corner);
      if (box.isEmpty()) continue;
      box.min().array() -= on_surface;
      box.max().array() += on_surface;
      surfaces_.push_back({plane.plane, box});
    }
  }
  // Whether such a surface is at a point before the wall: a plane of the graph, or something was seen on both sides of it.
  [[nodiscard]] bool hold(const Eigen::Vector3d& p) const {
    if (seen_.near(p + along_) && seen_.near(p - along_)) return true;
    return std::any_of(surfaces_.begin(), surfaces_.end(),
                       [&](const auto& surface) { return surface.second.contains(p) && std::abs(surface.first.distance(p)) < on_surface; });
  }

 private:
  static constexpr double along_it = 0.3;  // [m]: more than two voxels

  Eigen::Vector3d along_;
  const Seen& seen_;
  std::vector<std::pair<Plane, Eigen::AlignedBox3d>> surfaces_;
};

// Decides whether a hole mirrors, and at which depth.
void judge(const Wall& wall, const Across& across_it, const Seen& seen, Hole& hole) {
  if (hole.beyond.size() < least_images) return;
  std::size_t most = 0, telling = 0, telling_images = 0;
  for (int depth = 0; depth < depths; ++depth) {
    std::size_t found = 0;
    for (const Eigen::Vector3f& point : hole.beyond) found += seen.near(image_of(point.cast<double>(), wall, depth)) ? 1 : 0;
    if (found > most) {
      most = found;
      hole.depth = depth;
    }
  }
  if (static_cast<double>(most) < (hole.reaches_floor ? mirrored_door : mirrored_share) * static_cast<double>(hole.beyond.size())) return;
  // What goes on behind the wall, as floors do, is its own image whether the hole mirrors or not.
  for (const Eigen::Vector3f& point : hole.beyond) {
    const Eigen::Vector3d image = image_of(point.cast<double>(), wall, hole.depth);
    if (across_it.hold(image)) continue;
    ++telling;
    telling_images += seen.near(image) ? 1 : 0;
  }
  if (telling >= least_images && static_cast<double>(telling_images) < mirrored_share * static_cast<double>(telling)) return;
  const auto returns = std::count_if(hole.cells.begin(), hole.cells.end(), [&](std::uint32_t i) { return wall.returns[i] >> hole.depth & 1; });
  hole.mirrors = !hole.reaches_floor || static_cast<double>(returns) >= pane_returns * static_cast<double>(hole.cells.size());
}

// Whether some of what is seen through a hole that doesn't mirror as a whole may be an image.
bool may_glimmer(const Wall& wall, const Across& across_it, const Seen& seen, const Hole& hole) {
  constexpr std::size_t most = 500;
  const std::size_t step = hole.beyond.size() / most + 1;
  std::array<std::size_t, depths> found{};
  for (std::size_t k = 0; k < hole.beyond.size(); k += step) {
    const Eigen::Vector3d p = hole.beyond[k].cast<double>();
    if (across_it.hold(image_of(p, wall, 0))) continue;
    for (int depth = 0; depth < depths; ++depth) found[static_cast<std::size_t>(depth)] += seen.near(image_of(p, wall, depth)) ? 1 : 0;
  }
  return *std::max_element(found.begin(), found.end()) * step * hole.stride >= least_images;
}

// Rays through cells behind the walls.
class Passes {
 public:
  explicit Passes(const Eigen::AlignedBox3d& bounds) {
    if (bounds.isEmpty()) return;  // nothing is counted
    cell_ = std::max(pass_cell, std::cbrt(bounds.volume() / most_pass_cells));
    origin_ = bounds.min().array() - border * cell_;
    size_ = (bounds.sizes() / cell_).array().ceil().cast<int>() + 2 * border;
    count_.assign(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()) * static_cast<std::size_t>(size_.z()), 0);
  }
  // Counts the ray behind the wall, up to where its end is `goes_on` deeper: so what it only grazes is not passed.
  void add(const Sight& sight, const Wall& wall) {
    const double before = wall.plane.distance(sight.eye);
    const double whole = before - wall.plane.distance(sight.p);
    double begin = before / whole;
    double end = std::min(1 - goes_on / whole, 1 - clearance / (sight.p - sight.eye).norm());
    const Eigen::Vector3d from = (sight.eye - origin_) / cell_;
    const Eigen::Vector3d way = (sight.p - sight.eye) / cell_;
    // Cut off within the border: a way that ends on the raster's edge could go on in its next row.
    constexpr double edge = 0.5 * border;
    for (int k = 0; k < 3; ++k) {
      if (std::abs(way[k]) < 1e-9) {
        if (!(from[k] >= edge && from[k] <= size_[k] - edge)) return;
        continue;
      }
      const double low = (edge - from[k]) / way[k];
      const double high = (size_[k] - edge - from[k]) / way[k];
      begin = std::max(begin, std::min(low, high));
      end = std::min(end, std::max(low, high));
    }
    if (!(begin < end)) return;  // also when nothing is to be counted
    const std::array<std::ptrdiff_t, 3> rows{1, size_.x(), static_cast<std::ptrdiff_t>(size_.x()) * size_.y()};
    walk_cells<3>(from + begin * way, from + end * way, rows, [&](std::ptrdiff_t i, std::int64_t, std::int64_t) {
      if (i < 0 || static_cast<std::size_t>(i) >= count_.size()) return true;
      std::uint8_t& count = count_[static_cast<std::size_t>(i)];
      if (count < least_passes) ++count;
      return true;
    });
  }
  [[nodiscard]] bool enough_at(const Eigen::Vector3d& p) const {
    const Eigen::Array3d at = (p - origin_).array() / cell_;
    if (count_.empty() || !((at >= 0).all() && (at < size_.cast<double>().array()).all())) return false;
    const Eigen::Array<std::ptrdiff_t, 3, 1> c = at.floor().cast<std::ptrdiff_t>();
    return count_[static_cast<std::size_t>(c.x() + size_.x() * (c.y() + size_.y() * c.z()))] >= least_passes;
  }

 private:
  static constexpr int border = 1;  // around what is asked for [cells]

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  double cell_ = pass_cell;
  std::vector<std::uint8_t> count_;
};

// A point that may be an image, one a voxel, and the hole through which it is seen.
struct Candidate {
  std::uint64_t voxel;
  Eigen::Vector3f p;
  int hole;
};

class Candidates {
 public:
  void add(const Eigen::Vector3d& p, int hole) {
    all_.push_back({key_of(p), p.cast<float>(), hole});
    if (all_.size() > 2 * settled_ + 100'000) settle();
  }
  const std::vector<Candidate>& all() {
    settle();
    return all_;
  }

 private:
  void settle() {
    std::stable_sort(all_.begin(), all_.end(), [](const Candidate& a, const Candidate& b) { return a.voxel < b.voxel; });
    all_.erase(std::unique(all_.begin(), all_.end(), [](const Candidate& a, const Candidate& b) { return a.voxel == b.voxel; }), all_.end());
    settled_ = all_.size();
  }

  std::vector<Candidate> all_;
  std::size_t settled_ = 0;
};

// Of what is seen through a hole that may show images, tells the voxels of images from what is there. An image is passed by rays, doesn't lie on a
// surface that goes on behind the wall, and nobody has seen anything there but through such holes; and for the hole to show images, a good part of
// all such points has something at its image, by the depth of one mirror.
void tell_apart(const std::vector<Candidate>& candidates, const Wall& wall, const Across& across_it, const Seen& seen, const Passes& passes,
                std::vector<std::uint64_t>& images, std::vector<Eigen::Vector3d>& there) {
  std::array<std::size_t, depths> found{};
  std::vector<Candidate> passed;
  for (const Candidate& c : candidates) {
    const Eigen::Vector3d p = c.p.cast<double>();
    if (!passes.enough_at(p) || seen.near(p) || across_it.hold(image_of(p, wall, 0))) {
      there.push_back(p);
      continue;
    }
    passed.push_back(c);
    for (int depth = 0; depth < depths; ++depth) found[static_cast<std::size_t>(depth)] += seen.near(image_of(p, wall, depth)) ? 1 : 0;
  }
  const auto best = std::max_element(found.begin(), found.end());
  const int depth = static_cast<int>(best - found.begin());
  const bool glimmers = *best >= least_images && static_cast<double>(*best) >= mirrored_share * static_cast<double>(passed.size());
  for (const Candidate& c : passed) {
    const Eigen::Vector3d p = c.p.cast<double>();
    if (glimmers && seen.near(image_of(p, wall, depth))) {
      images.push_back(c.voxel);
    } else {
      there.push_back(p);
    }
  }
}

}  // namespace

MirrorImages::MirrorImages(const GraphSnapshot& snapshot, const Pose& T_base_lidar) {
  std::vector<Wall> walls;
  for (const auto& [id, plane] : snapshot.planes) {
    if (auto wall = wall_of(plane)) walls.push_back(*std::move(wall));
  }
  if (walls.empty()) return;
  find_floors(snapshot, T_base_lidar, walls);

  Seen seen;  // but through holes that mirror
  visit_sights(snapshot, T_base_lidar, walls, [&](const Sight& sight) {
    for (const Meeting& m : sight.on) walls[m.wall].returns[m.cell] |= 1;
    for (const Meeting& m : sight.through) {
      std::uint16_t& passes = walls[m.wall].passes[m.cell];
      if (passes < least_rays) ++passes;
    }
    if (sight.through.empty()) seen.add(sight.p);
  });

  std::vector<Hole> holes = holes_of(walls);
  if (holes.empty()) return;
  visit_sights(snapshot, T_base_lidar, walls, [&](const Sight& sight) {
    bool through_a_hole = false;
    for (const Meeting& m : sight.through) {
      Wall& wall = walls[m.wall];
      const int hole = wall.hole[m.cell];
      if (hole < 0) continue;
      through_a_hole = true;
      const double s = wall.plane.distance(sight.p);
      for (int depth = 0; depth < depths; ++depth) {
        if (std::abs(s + depth_step * depth) < on_wall) wall.returns[m.cell] = static_cast<std::uint8_t>(wall.returns[m.cell] | 1 << depth);
      }
      if (s < -depth_step * (depths - 1) - behind) holes[static_cast<std::size_t>(hole)].sample(sight.p);
    }
    if (!sight.through.empty() && !through_a_hole) seen.add(sight.p);
  });
  seen.settle();
  Eigen::AlignedBox3d bounds;  // of what is seen through holes that may show images
  for (Hole& hole : holes) {
    const Wall& wall = walls[hole.wall];
    const Across across_it(snapshot, wall, seen);
    judge(wall, across_it, seen, hole);
    holes_ += hole.mirrors ? 1 : 0;
    hole.glimmers = !hole.mirrors && may_glimmer(wall, across_it, seen, hole);
    if (hole.glimmers) {
      for (const Eigen::Vector3f& p : hole.beyond) {
        if (wall.box.exteriorDistance(p.cast<double>()) < reach) bounds.extend(p.cast<double>());
      }
    }
    hole.beyond.clear();
    hole.beyond.shrink_to_fit();
  }
  if (std::none_of(holes.begin(), holes.end(), [](const Hole& hole) { return hole.mirrors || hole.glimmers; })) return;

  Passes passes(bounds);
  Candidates mirrored, glimmers;
  visit_sights(snapshot, T_base_lidar, walls, [&](const Sight& sight) {
    if (sight.through.empty()) return;
    int mirror = -1, glimmer = -1;
    for (const Meeting& m : sight.through) {
      const int i = walls[m.wall].hole[m.cell];
      if (i < 0) continue;
      const Hole& hole = holes[static_cast<std::size_t>(i)];
      const double s = walls[m.wall].plane.distance(sight.p);
      if (hole.mirrors && s + depth_step * hole.depth < -behind) mirror = i;
      if (hole.glimmers && s + depth_step * (depths - 1) < -behind) glimmer = i;
    }
    passes.add(sight, walls[sight.through.front().wall]);
    if (mirror >= 0) {
      mirrored.add(sight.p, mirror);
    } else if (glimmer >= 0) {
      glimmers.add(sight.p, glimmer);
    } else {
      seen.add(sight.p);
    }
  });
  seen.settle();
  std::map<int, std::vector<Candidate>> of_holes;
  for (const Candidate& c : glimmers.all()) of_holes[c.hole].push_back(c);
  std::vector<Eigen::Vector3d> there;
  for (const auto& [i, candidates] : of_holes) {
    const Wall& wall = walls[holes[static_cast<std::size_t>(i)].wall];
    tell_apart(candidates, wall, Across(snapshot, wall, seen), seen, passes, images_, there);
  }
  for (const Eigen::Vector3d& p : there) seen.add(p);
  seen.settle();
  for (const Candidate& c : mirrored.all()) {
    if (!seen.near(c.p.cast<double>())) images_.push_back(c.voxel);
  }
  std::sort(images_.begin(), images_.end());
  images_.erase(std::unique(images_.begin(), images_.end()), images_.end());
}

bool MirrorImages::operator()(const Eigen::Vector3d& p_map) const {
  if (!(p_map.cwiseAbs().maxCoeff() < farthest)) return false;  // false for NaN
  return std::binary_search(images_.begin(), images_.end(), key_of(p_map));
}

}  // namespace sgraph
