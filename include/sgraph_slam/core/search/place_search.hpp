#pragma once

#include <vector>

#include "sgraph_slam/core/search/layout.hpp"

namespace sgraph {

/// How well a layout fits into another; lengths of wall [m].
struct LayoutFit {
  double total = 0;         ///< walls of the query
  double matched = 0;       ///< where the map has the same face
  double unknown = 0;       ///< where the map says nothing
  double contradicted = 0;  ///< within the map's free space, or beside a face of the map; and faces of the map in the query's free space
  double long_pieces = 0;   ///< of the contradicted, those in one piece that is longer than a door leaf or a cupboard is wide
  double rms = 0;           ///< of the matched ones' distances across [m]

  /// What speaks against it [m of wall]: whole walls; short pieces may have moved, and an unknown wall may be new.
  [[nodiscard]] double cost() const { return long_pieces + 0.25 * (contradicted - long_pieces) + 0.5 * unknown; }
};

/// Where the query may be in the map.
struct PlaceHypothesis {
  Pose2d T_map_query;
  LayoutFit fit;
};

struct PlaceSearchResult {
  std::vector<PlaceHypothesis> hypotheses;  ///< the best first
  bool exhaustive = true;                   ///< false: there are more than were looked at
};

/// Finds every place of a map that looks like a query from above. All poses are compared (branch and bound over position and heading on a grid of
/// wall faces that keeps the sides apart; Hess et al., ICRA 2016, of which the bound is), then aligned to the faces and judged by what they
/// contradict. Holds the map's grids, so that several questions are cheap.
class PlaceSearch {
 public:
  explicit PlaceSearch(Layout map);

  /// The places where at least a share of the query's walls lie on walls of the map. Deterministic.
  [[nodiscard]] PlaceSearchResult find(const Layout& query) const;

  /// Moves a pose to where the walls fit best, and says how well.
  [[nodiscard]] PlaceHypothesis refined(const Layout& query, const Pose2d& guess) const;
  [[nodiscard]] LayoutFit fit(const Layout& query, const Pose2d& T_map_query) const;

  [[nodiscard]] const Layout& map() const { return map_; }

 private:
  using Mask = std::uint16_t;  // a bit a direction of faces

  struct Level {
    std::vector<Mask> cells;  // each holds its own and those of the 2^level - 1 cells beyond, in x and y
  };
  [[nodiscard]] Mask at(std::size_t level, int x, int y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_
               ? levels_[level].cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)]
               : Mask{0};
  }
  [[nodiscard]] std::vector<double> headings(const std::vector<WallSample>& samples, double step) const;

  Layout map_;
  WallIndex index_;
  double resolution_ = 0.1;  // [m]
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int width_ = 0;
  int height_ = 0;
  std::vector<Level> levels_;
  std::vector<double> histogram_;  // length of wall by heading of its normal [m], a degree each
};

}  // namespace sgraph
