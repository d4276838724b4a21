#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/math/voxel_index.hpp"
#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

struct SurfaceMapParams {
  double voxel = 1.0;
  int levels = 3;
  int wide_levels = 1;
  bool two_faces = true;
  int min_points = 8;
  int max_points = 400;
  double flat_ratio = 0.15;
  double flat_sigma = 0.03;

  void describe(ParamVisitor& v) {
    v.field("voxel", voxel, "m", {0.1, 10}, "Edge of the coarsest voxels.");
    v.field("levels", levels, "", {1, 5}, "Sizes of voxels, each half of the last; a point matches the coarsest flat one.");
    v.field("wide_levels", wide_levels, "", {0, 3},
            "Larger sizes, each twice the last, that only the first rough alignment of a scan may match where none of these does: for far walls of "
            "few stripes.");
    v.field("two_faces", two_faces, "Keep a Gaussian for each face of a wall in a voxel; off, for comparison: for the face seen first.");
    v.field("min_points", min_points, "", {3, 1000}, "Points that a voxel's Gaussian needs before it is used.");
    v.field("max_points", max_points, "", {10, 100000}, "Points after which a Gaussian stops learning.");
    v.field("flat_ratio", flat_ratio, "", {0.001, 1}, "A Gaussian is flat when its smallest variance is at most this share of the next.");
    v.field("flat_sigma", flat_sigma, "m", {0.001, 1},
            "... and its smallest standard deviation at most this, or 1.5 times what the sensor's noise, as the map shows it, makes of it.");
  }
};

/// A planar patch of the map, seen from the side its normal points to. One cache line.
struct alignas(64) Surface {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset = 0;  ///< the plane is `normal . p + offset = 0` [m]
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double variance = 0;  ///< of the points along the normal [m^2]

  [[nodiscard]] double distance(const Eigen::Vector3d& p) const { return normal.dot(p) + offset; }
};

/// A wall's surface with its normal level, through the same middle; floors and ceilings as they are; nothing for what is neither. A wall that is seen
/// as a low stripe alone leans by chance, and would hold the height, as would a patch of wall and floor together.
inline std::optional<Surface> plumb(const Surface& surface, const Eigen::Vector3d& up) {
  constexpr double of_wall = 0.2;   // largest part of a normal along the vertical
  constexpr double of_floor = 0.9;  // least
  const double slope = up.dot(surface.normal);
  if (std::abs(slope) > of_floor) return surface;
  if (std::abs(slope) > of_wall) return std::nullopt;
  Surface wall = surface;
  wall.normal = (surface.normal - slope * up).normalized();
  wall.offset = -wall.normal.dot(surface.mean);
  return wall;
}

/// Where a point looks for its surface.
enum class Reach {
  own,         ///< in the voxels around it
  wide,        ///< and in the larger ones
  neighbours,  ///< and in the largest ones next to it: for a poor first guess
};

/// How well it is known where a scan was taken: one after a gap in time may not be judged by the map.
enum class Placing { sure, unsure };

/// The local map of the odometry: Gaussians in voxels of several sizes, up to two a voxel, so that a wall's two faces are never mixed up (design:
/// odometry study, section 2). Nothing is forgotten; memory grows with the area seen and not with the number of scans.
class SurfaceMap {
 public:
  explicit SurfaceMap(const SurfaceMapParams& params);

  /// Takes a point in the map's frame, seen from `sensor`. It counts after `update()`. `normal`, when its scan shows it, of the surface it lies on: a
  /// single stripe doesn't tell which way it leans. A surface that is well known takes no point beside it that is surely placed.
  void insert(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, const std::optional<Eigen::Vector3f>& normal = std::nullopt,
              Placing placing = Placing::sure);

  /// Fits what has changed enough since the last call.
  void update();

  /// The surface that `point`, seen from `sensor`, lies on: of the coarsest flat voxel around it that faces the sensor and is nearer than `gate` [m];
  /// null when there is none. `reach` says where else to look.
  [[nodiscard]] const Surface* match(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, double gate, Reach reach = Reach::own) const;

  /// Typical standard deviation of points on their surface, over the map [m]: the sensor's noise as the data shows it. 0 while the map is empty.
  [[nodiscard]] double noise() const { return noise_; }

  /// The flat surfaces in voxels of the edge `params.voxel`, but for the `first` voxels.
  [[nodiscard]] std::vector<Surface> surfaces(std::size_t first = 0) const;
  /// How many voxels of that edge there are.
  [[nodiscard]] std::size_t surface_voxels() const { return levels_.front().voxels.size(); }

  /// Edge of the finest voxels [m].
  [[nodiscard]] double finest_edge() const { return 1.0 / inverse_finest_; }

  [[nodiscard]] std::size_t voxel_count() const;
  [[nodiscard]] bool empty() const { return voxel_count() == 0; }

 private:
  // One side of a voxel: what a fit takes.
  struct Side {
    std::uint32_t count = 0;
    std::uint32_t fitted = 0;  // count at the last fit
    bool flat = false;
    bool changed = false;
    float ratio = 1;                                      // smallest variance by the next
    float incidence = 0;                                  // mean square of the cosine between rays and normal
    std::uint32_t with_normal = 0;                        // points that came with one
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();        // relative to the origin of the voxel
    std::array<double, 6> outer{};                        // xx xy xz yy yz zz
    Eigen::Vector3f seen_from = Eigen::Vector3f::Zero();  // sum of unit rays to the sensor
    std::array<float, 6> rays{};                          // sum of their outer products, as above
    std::array<float, 6> normals{};                       // sum of the outer products of the points' own normals
  };
  struct Voxel {
    std::uint64_t key;
    Eigen::Vector3d origin;
    std::array<Side, 2> sides;
  };
  // What a match reads lies apart from what a fit takes: the index's tags say which sides are flat (bit 0 and 1), `surfaces` holds two of each voxel.
  struct Level {
    double edge;   // [m]
    int halvings;  // of the finest level's cells
    VoxelIndex index;
    std::vector<Voxel> voxels;
    std::vector<Surface> surfaces;
    std::vector<std::uint32_t> changed;
  };
  // A point that looks for its surface.
  struct Query {
    const Eigen::Vector3d& point;
    Eigen::Vector3d ray;
    double least_cosine;  // along the ray: what faces the sensor
    double gate;
  };

  [[nodiscard]] static const Surface* match_in(const Level& level, const VoxelIndex::Cell& cell, const Query& query);
  [[nodiscard]] int side_for(const Level& level, std::uint32_t voxel, const Eigen::Vector3d& ray) const;
  void fit(Level& level, std::uint32_t voxel, int side);
  void fit_changed();
  void update_noise();

  SurfaceMapParams params_;
  std::vector<Level> levels_;  // from `params.voxel` down to the finest, then the wide ones upwards
  double inverse_finest_ = 1;  // [1/m]
  double noise_ = 0;
  double range_variance_ = 0;  // of a point along its ray [m^2]
  double flat_variance_;
};

/// The surface that a moving point lies on, looked for again only when it may be another.
class CachedMatch {
 public:
  /// As `map.match` with the same arguments, but a surface found for the point when it was less than a tenth of the finest voxel away is kept while
  /// it is nearer than the gate, and none found stays none. The gate must not grow from call to call.
  const Surface* find(const SurfaceMap& map, const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, double gate, Reach reach = Reach::own) {
    const double near = 0.1 * map.finest_edge();
    const bool same_place = asked_ && (point - at_).squaredNorm() < near * near;
    if (!same_place || (surface_ != nullptr && std::abs(surface_->distance(point)) >= gate)) {
      surface_ = map.match(point, sensor, gate, reach);
      at_ = point;
      asked_ = true;
    }
    return surface_;
  }

 private:
  Eigen::Vector3d at_ = Eigen::Vector3d::Zero();
  const Surface* surface_ = nullptr;
  bool asked_ = false;
};

}  // namespace sgraph
