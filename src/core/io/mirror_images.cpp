#include "sgraph_slam/core/io/mirror_images.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "mirror_walls.hpp"
#include "ray_passes.hpp"

namespace sgraph {
namespace mirrors {
namespace {

constexpr double sill = 0.35;               // a hole that begins higher above the floor is no passage [m]
constexpr int least_rays = 3;               // through a cell, for a hole
constexpr std::size_t least_images = 40;    // points through a hole, to judge it
constexpr double pane_returns = 0.15;       // of the cells of a hole, with points on the wall: it is glass
constexpr double mirrored_share = 0.3;      // of the points behind a window that have something at their image
constexpr double glass_returns = 0.3;       // of the cells of a hole, with points at the mirror's depth: it is glass, and not a door with its frame
constexpr double glass_share = 0.15;        // of the points that rays pass behind such glass that have something at their image
constexpr double mirrored_door = 0.45;      // the same of a hole that reaches the floor: a room may look like the one before the door
constexpr double across = 0.3;              // most cosine between the normals of a wall and of a surface that goes on as its own image
constexpr double on_surface = 0.1;          // [m]: what a plane's estimate and the mirror's depth may be off
constexpr std::size_t most_samples = 2000;  // of the points seen through a hole

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

// Share of a hole's cells in which something was seen where a pane would be.
double returned(const Wall& wall, const Hole& hole, int depth) {
  const auto count = std::count_if(hole.cells.begin(), hole.cells.end(), [&](std::uint32_t i) { return wall.returns[i] >> depth & 1; });
  return static_cast<double>(count) / static_cast<double>(hole.cells.size());
}

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
  hole.mirrors = !hole.reaches_floor || returned(wall, hole, hole.depth) >= pane_returns;
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
// all such points has something at its image, by the depth of one mirror. Half of that is enough where a pane is seen at this depth: between it and
// the room, points float that are neither.
void tell_apart(const std::vector<Candidate>& candidates, const Wall& wall, const Hole& hole, const Across& across_it, const Seen& seen,
                const RayPasses& passes, std::vector<std::uint64_t>& images, std::vector<Eigen::Vector3d>& there) {
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
  const double share = returned(wall, hole, depth) >= glass_returns ? glass_share : mirrored_share;
  const bool glimmers = *best >= least_images && static_cast<double>(*best) >= share * static_cast<double>(passed.size());
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
}  // namespace mirrors

MirrorImages::MirrorImages(const GraphSnapshot& snapshot, const Pose& T_base_lidar) {
  using namespace mirrors;
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

  RayPasses passes(bounds);
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
    const Hole& hole = holes[static_cast<std::size_t>(i)];
    const Wall& wall = walls[hole.wall];
    tell_apart(candidates, wall, hole, Across(snapshot, wall, seen), seen, passes, images_, there);
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
  using namespace mirrors;
  if (!(p_map.cwiseAbs().maxCoeff() < farthest)) return false;  // false for NaN
  return std::binary_search(images_.begin(), images_.end(), key_of(p_map));
}

}  // namespace sgraph
