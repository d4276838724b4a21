#include "plane_grid.hpp"

#include <algorithm>

#include <Eigen/Geometry>

namespace sgraph {
namespace {

constexpr float cell_edge = 0.2F;     // [m]
constexpr float most_cells = 400.0F;  // along one axis: larger planes get larger cells
constexpr float turn_spacing = 0.2F;  // of the points of a ring, over the spacing of the rings: the coarsest of spinning LiDARs
constexpr std::size_t outline_rows = 128;

// The cells that hold points: most of a large plane's are empty.
struct Occupied {
  std::vector<int> number_of_cell;     // -1 for an empty one
  std::vector<int> cell;               // the rest by number, in order of their first points
  std::vector<Eigen::Vector2f> reach;  // how far each reaches for others along the axes, in cells
  std::vector<int> parent;             // of the union-find forest
  std::vector<int> number_of_point;

  int root_of(int number) {
    while (parent[static_cast<std::size_t>(number)] != number) {
      const int above = parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(number)])];
      number = parent[static_cast<std::size_t>(number)] = above;
    }
    return number;
  }
};

// Of the ellipse of this reach, so many rows from its middle, in cells.
int half_width(const Eigen::Vector2f& reach, int row) {
  const float share = static_cast<float>(row) / reach.y();
  return static_cast<int>(reach.x() * std::sqrt(std::max(0.0F, 1.0F - share * share)));
}

PlaneCells cells_around(const PointSet& points, const std::vector<std::uint32_t>& inliers, const PlaneF& plane, float max_gap) {
  PlaneCells cells{PlaneAxes(plane.normal)};
  Eigen::AlignedBox2f box;
  for (const std::uint32_t i : inliers) box.extend(cells.axes(points.position(i)));
  cells.edge = std::max(cell_edge, box.sizes().maxCoeff() / most_cells);
  const float border = cells.edge + max_gap;  // room for masks
  cells.origin = box.min().array() - border;
  cells.columns = static_cast<int>((box.sizes().x() + 2 * border) / cells.edge) + 1;
  cells.rows = static_cast<int>((box.sizes().y() + 2 * border) / cells.edge) + 1;
  return cells;
}

Occupied occupied_cells(const PointSet& points, const std::vector<std::uint32_t>& inliers, const PlaneF& plane, const PlaneCells& cells,
                        const SegmentationParams& params) {
  Occupied occupied;
  occupied.number_of_cell.assign(static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows), -1);
  occupied.number_of_point.reserve(inliers.size());
  const auto gap = static_cast<float>(params.gap);
  const auto max_gap = static_cast<float>(std::max(params.gap, params.max_gap));
  const float rings = 1.5F * static_cast<float>(params.beam_spacing) / std::max(std::abs(plane.d), 0.05F);
  // Along a wall the LiDAR's turn sets the points, much closer together: a gap that is wide for them is a doorway, however far apart the rings.
  const float along = (1.0F - std::abs(plane.normal.z())) * turn_spacing + std::abs(plane.normal.z());
  for (const std::uint32_t i : inliers) {
    const int cell = cells.at(points.position(i));
    int& number = occupied.number_of_cell[static_cast<std::size_t>(cell)];
    if (number < 0) {
      number = static_cast<int>(occupied.cell.size());
      occupied.cell.push_back(cell);
      occupied.parent.push_back(number);
      // Rings on a plane lie apart by range * spacing / cos(incidence) = range^2 * spacing / distance of the plane.
      const float apart = rings * points.position(i).squaredNorm();
      occupied.reach.emplace_back(std::min(std::max(gap, along * apart), max_gap) / cells.edge, std::min(std::max(gap, apart), max_gap) / cells.edge);
    }
    occupied.number_of_point.push_back(number);
  }
  return occupied;
}

void unite_within_reach(const PlaneCells& cells, Occupied& occupied) {
  for (std::size_t k = 0; k < occupied.cell.size(); ++k) {
    const int row = occupied.cell[k] / cells.columns, column = occupied.cell[k] % cells.columns;
    const Eigen::Vector2f reach = occupied.reach[k];
    const int steps = static_cast<int>(reach.y());
    int root = occupied.root_of(static_cast<int>(k));
    for (int i = std::max(0, row - steps); i <= std::min(cells.rows - 1, row + steps); ++i) {
      const int width = half_width(reach, i - row);
      for (int j = std::max(0, column - width); j <= std::min(cells.columns - 1, column + width); ++j) {
        const int other = occupied.number_of_cell[static_cast<std::size_t>(i * cells.columns + j)];
        if (other < 0 || occupied.parent[static_cast<std::size_t>(other)] == root) continue;
        const int other_root = occupied.root_of(other);
        occupied.parent[static_cast<std::size_t>(std::max(root, other_root))] = std::min(root, other_root);
        root = std::min(root, other_root);
      }
    }
  }
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Andrew's monotone chain, counter-clockwise.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  const auto before = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return {};
  std::vector<Eigen::Vector2d> hull(2 * points.size());
  std::size_t k = 0;
  const auto push = [&](const Eigen::Vector2d& p, std::size_t least) {
    while (k >= least && cross(hull[k - 2], hull[k - 1], p) <= 0) --k;
    hull[k++] = p;
  };
  for (const auto& p : points) push(p, 2);
  const std::size_t lower = k + 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) push(points[i], lower);
  hull.resize(k - 1);
  if (hull.size() < 3) hull.clear();
  return hull;
}

}  // namespace

PlaneAxes::PlaneAxes(const Eigen::Vector3f& normal) {
  const Eigen::Vector3f across = std::abs(normal.z()) < 0.9F ? Eigen::Vector3f::UnitZ().cross(normal) : Eigen::Vector3f::UnitY().cross(normal);
  u = across.normalized();
  v = normal.cross(u);
}

Pieces connected_pieces(const PointSet& points, const std::vector<std::uint32_t>& inliers, const PlaneF& plane, const SegmentationParams& params) {
  Pieces result{cells_around(points, inliers, plane, static_cast<float>(std::max(params.gap, params.max_gap))), {}};
  if (inliers.empty()) return result;
  const PlaneCells& cells = result.cells;
  Occupied occupied = occupied_cells(points, inliers, plane, cells, params);
  unite_within_reach(cells, occupied);

  std::vector<int> piece_of(occupied.cell.size(), -1);  // by the number of the root, then of each cell
  for (std::size_t k = 0; k < occupied.cell.size(); ++k) {
    int& piece_number = piece_of[static_cast<std::size_t>(occupied.root_of(static_cast<int>(k)))];
    if (piece_number < 0) {
      piece_number = static_cast<int>(result.pieces.size());
      result.pieces.emplace_back();
    }
    piece_of[k] = piece_number;
    Piece& piece = result.pieces[static_cast<std::size_t>(piece_number)];
    const int cell = occupied.cell[k];
    piece.cells.push_back(cell);
    piece.reach.push_back(occupied.reach[k]);
    const Eigen::Vector2f corner =
        cells.origin + cells.edge * Eigen::Vector2f(static_cast<float>(cell % cells.columns), static_cast<float>(cell / cells.columns));
    piece.box.extend(corner);
    piece.box.extend(Eigen::Vector2f(corner.array() + cells.edge));
  }
  for (std::size_t k = 0; k < inliers.size(); ++k) {
    const int number = piece_of[static_cast<std::size_t>(occupied.number_of_point[k])];
    result.pieces[static_cast<std::size_t>(number)].members.push_back(inliers[k]);
  }
  return result;
}

Mask mask_of(const PlaneCells& cells, const std::vector<const Piece*>& pieces) {
  Mask mask{cells, std::vector<char>(static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows), 0)};
  for (const Piece* piece : pieces) {
    for (std::size_t k = 0; k < piece->cells.size(); ++k) {
      const int row = piece->cells[k] / cells.columns, column = piece->cells[k] % cells.columns;
      const Eigen::Vector2f reach = piece->reach[k].cwiseMax(1.0F);
      const int steps = static_cast<int>(reach.y());
      for (int i = std::max(0, row - steps); i <= std::min(cells.rows - 1, row + steps); ++i) {
        const int width = half_width(reach, i - row);
        const auto first = mask.set.begin() + i * cells.columns;
        std::fill(first + std::max(0, column - width), first + std::min(cells.columns - 1, column + width) + 1, 1);
      }
    }
  }
  return mask;
}

std::vector<Eigen::Vector3d> outline(const PointSet& points, const std::vector<std::uint32_t>& which, const Plane& plane) {
  if (which.size() < 3) return {};
  const PlaneAxes axes(plane.normal.cast<float>());
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const std::uint32_t i : which) {
    const float v = axes.v.dot(points.position(i));
    low = std::min(low, v);
    high = std::max(high, v);
  }
  // The hull's corners are among the leftmost and rightmost points of each of many thin rows.
  const float scale = static_cast<float>(outline_rows) / std::max(high - low, 1e-3F) * 0.9999F;
  struct Row {
    Eigen::Vector2f left{std::numeric_limits<float>::infinity(), 0}, right{-std::numeric_limits<float>::infinity(), 0};
  };
  std::vector<Row> rows(outline_rows);
  for (const std::uint32_t i : which) {
    const Eigen::Vector2f q = axes(points.position(i));
    Row& row = rows[std::min(static_cast<std::size_t>((q.y() - low) * scale), outline_rows - 1)];
    if (q.x() < row.left.x()) row.left = q;
    if (q.x() > row.right.x()) row.right = q;
  }
  std::vector<Eigen::Vector2d> ends;
  for (const Row& row : rows) {
    if (row.left.x() > row.right.x()) continue;
    ends.emplace_back(row.left.cast<double>());
    ends.emplace_back(row.right.cast<double>());
  }
  const Eigen::Vector3d u = (axes.u.cast<double>() - plane.normal.dot(axes.u.cast<double>()) * plane.normal).normalized();
  const Eigen::Vector3d v = plane.normal.cross(u);
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::Vector2d& q : convex_hull(std::move(ends))) corners.push_back(q.x() * u + q.y() * v - plane.d * plane.normal);
  return corners;
}

}  // namespace sgraph
