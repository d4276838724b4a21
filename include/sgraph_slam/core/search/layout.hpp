#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace sgraph {

/// A stretch of a wall's face seen from above.
struct WallPiece {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  ///< into the free space that it was seen from
};

/// What lay open between the sensor and a wall that it saw: the triangle of the three points, seen from above.
struct Sight {
  Eigen::Vector2d sensor = Eigen::Vector2d::Zero();
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
};

/// A point of a wall's face, standing for `spacing` [m] of it.
struct WallSample {
  static constexpr double spacing = 0.2;

  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
  bool solid = true;  ///< nothing was seen through it: no open door, no low furniture
};

/// Cells that were seen to be free, counted by how many sights say so.
class SeenFree {
 public:
  static constexpr double cell = 0.1;    ///< edge [m]
  static constexpr double margin = 0.3;  ///< before a seen wall that is not counted as free [m]

  explicit SeenFree(const std::vector<Sight>& sights);

  /// Whether at least `votes` sights say that the point is free.
  [[nodiscard]] bool contains(const Eigen::Vector2d& point, int votes) const;

 private:
  void add(const Sight& sight);

  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> votes_;
};

/// Walls and free space around a robot, or of a whole map, seen from above in a level frame.
class Layout {
 public:
  /// `votes`: sights that it takes to call a place free; one of many may be wrong.
  Layout(std::vector<WallPiece> pieces, const std::vector<Sight>& sights, int votes);

  [[nodiscard]] const std::vector<WallPiece>& pieces() const { return pieces_; }
  /// One a stretch of wall, however many pieces show it.
  [[nodiscard]] const std::vector<WallSample>& samples() const { return samples_; }
  [[nodiscard]] bool is_free(const Eigen::Vector2d& point) const { return free_.contains(point, votes_); }

 private:
  std::vector<WallPiece> pieces_;
  SeenFree free_;
  int votes_;
  std::vector<WallSample> samples_;
};

/// Samples (by index) that lie beside each other on faces that look the same way, piece by piece.
std::vector<std::vector<std::size_t>> joined_pieces(const std::vector<WallSample>& samples);

/// A motion in the plane: p_a = R(yaw) p_b + translation.
struct Pose2d {
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();
  double yaw = 0;

  [[nodiscard]] Eigen::Matrix2d matrix() const;
  [[nodiscard]] Pose2d inverse() const;
  friend Eigen::Vector2d operator*(const Pose2d& a, const Eigen::Vector2d& p) { return a.matrix() * p + a.translation; }
};

/// The faces of a layout by place, to find the one at a point quickly.
class WallIndex {
 public:
  explicit WallIndex(const Layout& layout);

  struct Hit {
    Eigen::Vector2d normal;
    double distance = 0;  ///< of the point from the face, positive on its free side [m]
  };
  /// The nearest face within `reach` [m] across that looks the same way within the angle of `cosine`, and that was seen at the point, or up to
  /// `reach` beside it.
  [[nodiscard]] std::optional<Hit> nearest(const Eigen::Vector2d& point, const Eigen::Vector2d& normal, double reach, double cosine) const;

 private:
  static constexpr double cell_ = 1.0;  // [m]
  const Layout& layout_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int width_ = 0;
  int height_ = 0;
  std::vector<std::vector<std::uint32_t>> pieces_;  // by cell
};

}  // namespace sgraph
