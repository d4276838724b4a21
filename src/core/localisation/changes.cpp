#include "sgraph_slam/core/localisation/changes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "sgraph_slam/core/io/occupancy_grid.hpp"
#include "sgraph_slam/core/io/storey_view.hpp"
#include "sgraph_slam/core/store/stored_clouds.hpp"

namespace sgraph {
namespace {

constexpr double beside = 0.15;        // [m] an obstacle as near to one seen before is the same: noise, the map's error, cells
constexpr double joined = 0.2;         // [m] between two cells of one piece
constexpr double shortest = 0.3;       // [m] of a piece: what is smaller may have been missed
constexpr double longest_move = 1.5;   // [m] farther off it is taken for another thing
constexpr double one_size = 2;         // the larger of two lengths that may be one thing's, against the smaller
constexpr double shortest_wall = 1.5;  // [m]; leaves of doors and most furniture are shorter
constexpr double straight = 0.3;       // [m] across, of a wall seen from both sides, or a leaf: its thickness and the cells that noise reaches
constexpr double widest_door = 1.6;    // [m] of one leaf
constexpr double jamb = 0.2;           // [m] from a leaf's end to the middle of where its jamb is sought

using Points = std::vector<Eigen::Vector2d>;

// One session's keyframes, with their clouds in the map's file.
GraphSnapshot part_of(const GraphSnapshot& snapshot, const StoredMap& map, std::int64_t session) {
  GraphSnapshot part = snapshot;
  for (auto keyframe = part.keyframes.begin(); keyframe != part.keyframes.end();) {
    keyframe = map.session_of.at(keyframe->first) == session ? std::next(keyframe) : part.keyframes.erase(keyframe);
  }
  return part;
}

// What the ground was like before a session: what the newest session that knows says of each place.
class Before {
 public:
  void add(OccupancyGrid grid) { grids_.push_back(std::move(grid)); }

  [[nodiscard]] std::int8_t at(const Eigen::Vector2d& p) const {
    for (auto grid = grids_.rbegin(); grid != grids_.rend(); ++grid) {
      const std::int8_t cell = grid->at(p);
      if (cell != OccupancyGrid::unknown) return cell;
    }
    return OccupancyGrid::unknown;
  }

  [[nodiscard]] const std::vector<OccupancyGrid>& grids() const { return grids_; }

 private:
  std::vector<OccupancyGrid> grids_;
};

Points obstacles_of(const OccupancyGrid& grid) {
  Points points;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x);
      if (grid.cells[i] == OccupancyGrid::occupied) points.push_back(grid.origin + grid.resolution * Eigen::Vector2d(x + 0.5, y + 0.5));
    }
  }
  return points;
}

// Whether an obstacle stands within `beside` of a point.
template <class Ground>
bool is_obstructed(const Ground& ground, const Eigen::Vector2d& at, double resolution) {
  const int reach = static_cast<int>(std::ceil(beside / resolution));
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      if (ground.at(at + resolution * Eigen::Vector2d(x, y)) == OccupancyGrid::occupied) return true;
    }
  }
  return false;
}

// The obstacles that stand free in the other state of the ground: without one beside.
template <class Ground>
Points otherwise(const Points& obstacles, const Ground& other, double resolution) {
  Points points;
  for (const Eigen::Vector2d& p : obstacles) {
    if (other.at(p) == OccupancyGrid::free && !is_obstructed(other, p, resolution)) points.push_back(p);
  }
  return points;
}

std::vector<Points> pieces_of(const Points& points) {
  std::vector<Points> pieces;
  std::vector<bool> taken(points.size(), false);
  for (std::size_t first = 0; first < points.size(); ++first) {
    if (taken[first]) continue;
    taken[first] = true;
    Points piece{points[first]};
    for (std::size_t next = 0; next < piece.size(); ++next) {
      const Eigen::Vector2d at = piece[next];
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (taken[i] || (points[i] - at).squaredNorm() > joined * joined) continue;
        taken[i] = true;
        piece.push_back(points[i]);
      }
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

struct Piece {
  Eigen::Vector2d center;
  Eigen::Vector2d direction;  // of its longer axis
  double length;              // along it, with the cells at its ends
  double width;
};

Piece measured(const Points& points, double resolution) {
  Piece piece{Eigen::Vector2d::Zero(), Eigen::Vector2d::UnitX(), 0, 0};
  for (const Eigen::Vector2d& p : points) piece.center += p / static_cast<double>(points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : points) spread += (p - piece.center) * (p - piece.center).transpose();
  const Eigen::Matrix2d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors();  // the longer one last
  std::array<double, 2> size{};
  for (int k = 0; k < 2; ++k) {
    double low = HUGE_VAL;
    double high = -HUGE_VAL;
    for (const Eigen::Vector2d& p : points) {
      const double at = axes.col(k).dot(p);
      low = std::min(low, at);
      high = std::max(high, at);
    }
    size[static_cast<std::size_t>(k)] = high - low + resolution;
  }
  piece.direction = axes.col(size[1] >= size[0] ? 1 : 0);
  piece.length = std::max(size[0], size[1]);
  piece.width = std::min(size[0], size[1]);
  return piece;
}

std::vector<Piece> large_pieces(const Points& points, double resolution) {
  std::vector<Piece> pieces;
  for (const Points& piece : pieces_of(points)) {
    const Piece found = measured(piece, resolution);
    if (found.length >= shortest) pieces.push_back(found);
  }
  return pieces;
}

// Whether a piece fills the gap between two jambs, which stand while it does not.
template <class Ground>
bool is_leaf(const Piece& piece, const Ground& without, double resolution) {
  if (piece.length > widest_door || piece.width >= straight) return false;
  const Eigen::Vector2d end = (0.5 * piece.length + jamb) * piece.direction;
  return is_obstructed(without, piece.center - end, resolution) && is_obstructed(without, piece.center + end, resolution);
}

template <class Ground>
MapChange::Kind kind_of(const Piece& piece, bool appeared, const Ground& without, double resolution) {
  using Kind = MapChange::Kind;
  if (is_leaf(piece, without, resolution)) return appeared ? Kind::door_closed : Kind::door_opened;
  if (piece.length >= shortest_wall && piece.width < straight) return appeared ? Kind::wall_new : Kind::wall_gone;
  return appeared ? Kind::appeared : Kind::gone;
}

// A thing that is gone and one of its size that has appeared near by are one that has moved; the nearest first.
void pair_moves(std::vector<MapChange>& changes) {
  using Kind = MapChange::Kind;
  while (true) {
    MapChange* gone = nullptr;
    MapChange* appeared = nullptr;
    double least = longest_move;
    for (MapChange& a : changes) {
      for (MapChange& b : changes) {
        const double distance = (a.center - b.center).norm();
        if (a.kind != Kind::gone || b.kind != Kind::appeared || distance >= least) continue;
        if (std::max(a.length, b.length) > one_size * std::min(a.length, b.length)) continue;
        least = distance;
        gone = &a;
        appeared = &b;
      }
    }
    if (gone == nullptr) return;
    appeared->kind = Kind::moved;
    appeared->from = gone->center;
    appeared->length = std::max(appeared->length, gone->length);
    changes.erase(changes.begin() + (gone - changes.data()));
  }
}

std::vector<MapChange> changes_on(const GraphSnapshot& snapshot, const StoredMap& map, std::int64_t session, int storey) {
  const OutputParams params;
  const auto grid_of = [&](std::int64_t id) {
    const GraphSnapshot part = of_storey(part_of(snapshot, map, id), storey);
    return make_occupancy_grid(part, map.sessions.at(id).T_base_lidar, params);
  };
  Before before;
  for (const auto& [id, about] : map.sessions) {
    if (id < session) before.add(grid_of(id));
  }
  const OccupancyGrid now = grid_of(session);
  Points known;
  for (const OccupancyGrid& grid : before.grids()) {
    for (const Eigen::Vector2d& p : obstacles_of(grid)) {
      if (before.at(p) == OccupancyGrid::occupied) known.push_back(p);
    }
  }
  std::vector<MapChange> changes;
  const auto add = [&](const Points& obstacles, bool appeared, const auto& without) {
    for (const Piece& piece : large_pieces(otherwise(obstacles, without, now.resolution), now.resolution)) {
      const MapChange::Kind kind = kind_of(piece, appeared, without, now.resolution);
      const bool door = kind == MapChange::Kind::door_closed || kind == MapChange::Kind::door_opened;
      changes.push_back(
          {kind, piece.center, piece.center, piece.length + (door ? 2 * beside : 0), storey});  // what lies beside the jambs was left out
    }
  };
  add(obstacles_of(now), true, before);
  add(known, false, now);
  pair_moves(changes);
  return changes;
}

const char* words_of(MapChange::Kind kind) {
  switch (kind) {
    case MapChange::Kind::appeared: return "new";
    case MapChange::Kind::gone: return "gone";
    case MapChange::Kind::moved: return "moved";
    case MapChange::Kind::wall_new: return "wall new";
    case MapChange::Kind::wall_gone: return "wall gone";
    case MapChange::Kind::door_closed: return "door closed";
    case MapChange::Kind::door_opened: break;
  }
  return "door opened";
}

}  // namespace

std::string to_string(const MapChange& change) {
  std::array<char, 160> text{};
  if (change.kind == MapChange::Kind::moved) {
    std::snprintf(text.data(), text.size(), "moved: %.1f m from (%.1f, %.1f) to (%.1f, %.1f)", change.length, change.from.x(), change.from.y(),
                  change.center.x(), change.center.y());
  } else {
    std::snprintf(text.data(), text.size(), "%s: %.1f m at (%.1f, %.1f)", words_of(change.kind), change.length, change.center.x(), change.center.y());
  }
  return text.data();
}

std::vector<MapChange> changes_of(const StoredMap& map, std::int64_t session) {
  GraphSnapshot snapshot = snapshot_of(map);
  const auto clouds = std::make_shared<const StoredClouds>(map.path);
  for (auto& [id, keyframe] : snapshot.keyframes) keyframe.cloud = KeyframeCloud(clouds, id);
  std::vector<MapChange> changes;
  for (const int storey : storeys_of(snapshot)) {
    const std::vector<MapChange> here = changes_on(snapshot, map, session, storey);
    changes.insert(changes.end(), here.begin(), here.end());
  }
  std::stable_sort(changes.begin(), changes.end(), [](const MapChange& a, const MapChange& b) { return a.length > b.length; });
  return changes;
}

}  // namespace sgraph
