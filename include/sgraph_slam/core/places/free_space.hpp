#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/places/cell_bits.hpp"
#include "sgraph_slam/core/places/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// How many keyframes looked through a cell of the ground, by the height of their rays above the floor, and how many saw a surface in it.
struct FreeCell {
  std::uint16_t low = 0;   ///< rays below a window's sill: only doors and open floor let these through
  std::uint16_t mid = 0;   ///< rays above it, up to what furniture rarely reaches
  std::uint16_t high = 0;  ///< rays up to head height
  std::uint16_t over = 0;  ///< rays higher than that: over what does not reach the ceiling, or through it
  std::uint16_t hits = 0;  ///< surfaces between ankle and head height

  [[nodiscard]] bool seen_through() const { return low > 0 || mid > 0 || high > 0; }
  [[nodiscard]] bool free() const { return static_cast<int>(low) + mid + high > hits; }
};

/// The free space of a storey: a raster of its floor on which every keyframe has marked what its rays passed. Each keyframe keeps a thinned subset of
/// its rays in its own frame, so that its marks can be taken back and set again when its pose moves. One thread.
///
/// A copy has no raster until it is next given something to mark, which makes it from the marks, the same to the last bit: states to come back to are
/// copied often and come back to hardly ever.
class FreeSpace {
 public:
  explicit FreeSpace(const FreeSpaceParams& params) : params_(params) {}
  FreeSpace(const FreeSpace& other);
  FreeSpace& operator=(const FreeSpace& other) { return *this = FreeSpace(other); }
  FreeSpace(FreeSpace&&) = default;
  FreeSpace& operator=(FreeSpace&&) = default;
  ~FreeSpace() = default;

  /// Keeps rays of a keyframe's cloud (LiDAR frame, seen from its viewpoints). A keyframe is taken once, unless it has been let go.
  void add(KeyframeId id, const Cloud& cloud, const Pose& T_base_lidar);

  /// Marks the rays of keyframes not marked yet, and again those of keyframes that have moved by more than half a cell since. `T_map_base`: poses;
  /// keyframes without one are unmarked. Of more than eight keyframes at one spot the oldest is let go, so that what
  /// is kept grows with the area and not with the time. `floor_z`: height of the floor in the map [m].
  void update(const std::map<KeyframeId, Pose>& T_map_base, double floor_z);

  /// Marks some of the keyframes that aren't marked yet, at most so many, the oldest first, so that the next update() has less to do at once. The
  /// floor is taken to be where it was last; before the first update() nothing is marked. `pose_of`: T_map_base; null for a keyframe that is to wait.
  void mark_ahead(const std::function<const Pose*(KeyframeId)>& pose_of, int most);

  [[nodiscard]] double resolution() const { return params_.resolution; }
  /// Lower left corner of the first cell, map frame.
  [[nodiscard]] const Eigen::Vector2d& origin() const { return origin_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// The cells that are free.
  [[nodiscard]] const CellBits& free_cells() const { return free_; }
  /// Ends of the rays of keyframes no further than the given distance [m] from a position, as their marks are now; map frame.
  [[nodiscard]] std::vector<Eigen::Vector3d> ends_near(const Eigen::Vector2d& p, double keyframes_within, double ends_within) const;
  [[nodiscard]] double floor_z() const { return floor_z_; }
  /// The cell that holds a point of the map; an empty one outside the raster.
  [[nodiscard]] const FreeCell& at(const Eigen::Vector2d& p) const;

 private:
  // End of a ray in the keyframe's base frame, and from which of its viewpoints.
  struct Ray {
    std::int16_t x, y, z;  // [end_unit]
    std::uint16_t viewpoint;
  };
  struct Rays {
    std::vector<Eigen::Vector3f> viewpoints;  // base frame
    std::vector<Ray> rays;
  };
  struct Mark {
    Pose T_map_base;
    double floor_z = 0;
  };

  // What the rays of one keyframe passed: a piece of the raster, in scratch memory.
  struct Sweep;

  void make_raster();
  void thin_spot(KeyframeId newest);
  void mark(const Rays& rays, const Mark& at, int sign);
  void trace(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double floor_z, Sweep& sweep) const;
  void count(const Sweep& sweep, int sign);
  void make_room(const Eigen::Vector2d& low, const Eigen::Vector2d& high);
  void lay_out(const Eigen::Vector2i& first, const Eigen::Vector2i& size);

  FreeSpaceParams params_;
  std::map<KeyframeId, std::shared_ptr<const Rays>> rays_;  // shared by copies
  std::map<KeyframeId, Mark> marks_;
  Eigen::Vector2i first_ = Eigen::Vector2i::Zero();  // cell at the raster's lower left, counted from the map's origin
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int width_ = 0;
  int height_ = 0;
  double floor_z_ = 0;
  Eigen::Vector2i size_to_make_ = Eigen::Vector2i::Zero();  // of a copy's raster
  std::vector<FreeCell> cells_;
  CellBits free_{0, 0};                // of them, which are free
  std::vector<std::uint8_t> scratch_;  // of sweeps
};

}  // namespace sgraph
