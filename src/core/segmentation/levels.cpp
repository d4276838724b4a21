#include "levels.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sgraph {
namespace {

constexpr float patch_edge = 0.4F;       // [m]
constexpr float most_patches = 128.0F;   // along one axis: larger surfaces get larger patches
constexpr int fewest = 5;                // points that tell a patch's level
constexpr double most_counted = 20;      // points of a patch that count: where the robot was near isn't worth more
constexpr double level_rms = 0.25;       // rms of the patches' means, in units of the noise, below which a surface has one level
constexpr double level_scale = 0.3;      // how far, in units of the noise, the means of a plane's patches scatter ...
constexpr double level_step = 0.6;       // ... and how far off another level is, at least
constexpr double chance = 3.0;           // standard deviations of a patch's mean
constexpr double smallest_share = 0.03;  // of the points; less than this on other levels doesn't matter
constexpr int suggestions = 100;
constexpr double least_triangle = 0.5;  // twice the area of three patches that suggest a plane [m^2]
constexpr int rounds = 6;

struct Patch {
  int count = 0;
  double u = 0, v = 0, distance = 0;  // sums over the points; in the end means
  bool off = false;
};

// Square patches over a surface, by the two coordinates on its plane.
struct PatchGrid {
  PlaneAxes axes;
  Eigen::Vector2f origin = Eigen::Vector2f::Zero();
  float edge = patch_edge;
  int columns = 0, rows = 0;
  std::vector<Patch> patches{};

  // The patch of a point; null outside.
  Patch* at(const Eigen::Vector3f& p) {
    const Eigen::Vector2f q = (axes(p) - origin) / edge;
    const int column = static_cast<int>(std::floor(q.x())), row = static_cast<int>(std::floor(q.y()));
    return column < 0 || row < 0 || column >= columns || row >= rows ? nullptr : &patches[static_cast<std::size_t>(row * columns + column)];
  }
};

PatchGrid patches_of(const PointSet& points, const FlatSurface& surface) {
  const PlaneF plane(surface.plane);
  PatchGrid grid{PlaneAxes(plane.normal)};
  Eigen::AlignedBox2f box;
  for (const std::uint32_t i : surface.members) box.extend(grid.axes(points.position(i)));
  grid.edge = std::max(patch_edge, box.sizes().maxCoeff() / most_patches);
  grid.origin = box.min().array() - 0.01F;
  grid.columns = static_cast<int>((box.sizes().x() + 0.02F) / grid.edge) + 1;
  grid.rows = static_cast<int>((box.sizes().y() + 0.02F) / grid.edge) + 1;
  grid.patches.resize(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
  for (const std::uint32_t i : surface.members) {
    const Eigen::Vector3f p = points.position(i);
    Patch* patch = grid.at(p);
    if (!patch) continue;
    const Eigen::Vector2f q = grid.axes(p) - grid.origin;
    ++patch->count;
    patch->u += q.x();
    patch->v += q.y();
    patch->distance += plane.distance(p);
  }
  for (Patch& patch : grid.patches) {
    if (patch.count == 0) continue;
    patch.u /= patch.count;
    patch.v /= patch.count;
    patch.distance /= patch.count;
  }
  return grid;
}

// Distance of the patches from the surface's plane as a linear function of their place.
using Tilt = Eigen::Vector3d;

double off_by(const Patch& patch, const Tilt& tilt) { return patch.distance - tilt.dot(Eigen::Vector3d(1, patch.u, patch.v)); }

double weight_of(const Patch& patch) { return std::min<double>(patch.count, most_counted); }

// Least squares over the patches, by the weight that `share` (0..1) gives each.
template <class Share>
Tilt fitted(const std::vector<Patch>& patches, const Share& share) {
  Eigen::Matrix3d A = 1e-6 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Patch& patch : patches) {
    const double weight = weight_of(patch) * share(patch);
    const Eigen::Vector3d row(1, patch.u, patch.v);
    A += weight * row * row.transpose();
    b += weight * patch.distance * row;
  }
  return A.ldlt().solve(b);
}

// The plane on which most of the patches lie: the best of those that three patches suggest. All patches together would suggest one that leads from
// level to level.
Tilt plane_of_most(const std::vector<Patch>& patches, double scale, Tilt best) {
  const auto closeness = [scale](double r) { return 1 / (1 + r * r / (scale * scale)); };
  const auto score = [&](const Tilt& tilt) {
    double sum = 0;
    for (const Patch& patch : patches) sum += weight_of(patch) * closeness(off_by(patch, tilt));
    return sum;
  };
  double most = score(best);
  RandomStream random(patches.size(), 0);
  for (int k = 0; k < suggestions; ++k) {
    Eigen::Matrix3d A;
    Eigen::Vector3d b;
    for (int i = 0; i < 3; ++i) {
      const Patch& patch = patches[draw(random, patches.size())];
      A.row(i) << 1, patch.u, patch.v;
      b[i] = patch.distance;
    }
    if (std::abs(A.determinant()) < least_triangle) continue;
    const Tilt tilt = A.inverse() * b;
    const double now = score(tilt);
    if (now > most) {
      most = now;
      best = tilt;
    }
  }
  for (int round = 0; round < rounds; ++round) {
    best = fitted(patches, [&](const Patch& p) {
      const double close = closeness(off_by(p, best));
      return close * close;
    });
  }
  return best;
}

// Marks the patches that lie on another level; the number of their points.
int mark_off(std::vector<Patch>& patches, double noise) {
  std::vector<Patch> firm;
  std::copy_if(patches.begin(), patches.end(), std::back_inserter(firm), [](const Patch& patch) { return patch.count >= fewest; });
  const Tilt all = fitted(firm, [](const Patch&) { return 1.0; });
  double weights = 0, squares = 0;
  for (const Patch& patch : firm) {
    const double weight = weight_of(patch), r = off_by(patch, all);
    weights += weight;
    squares += weight * std::max(0.0, r * r - noise * noise / patch.count);
  }
  if (squares <= level_rms * level_rms * noise * noise * weights) return 0;
  const Tilt most = plane_of_most(firm, level_scale * noise, all);
  int count = 0;
  for (Patch& patch : patches) {
    patch.off =
        patch.count >= fewest && std::abs(off_by(patch, most)) > level_step * noise + chance * noise / std::sqrt(static_cast<double>(patch.count));
    if (patch.off) count += patch.count;
  }
  return count;
}

void uncover(Mask& mask, PatchGrid& grid, const Plane& plane) {
  const PlaneCells& cells = mask.cells;
  const Eigen::Vector3f normal = cells.axes.u.cross(cells.axes.v);
  for (std::size_t k = 0; k < mask.set.size(); ++k) {
    if (!mask.set[k]) continue;
    const int cell = static_cast<int>(k);
    const Eigen::Vector2f q =
        cells.origin + cells.edge * (Eigen::Vector2f(static_cast<float>(cell % cells.columns), static_cast<float>(cell / cells.columns)) +
                                     Eigen::Vector2f::Constant(0.5F));
    const Patch* patch = grid.at(q.x() * cells.axes.u + q.y() * cells.axes.v - static_cast<float>(plane.d) * normal);
    if (patch && patch->off) mask.set[k] = 0;
  }
}

}  // namespace

bool drop_other_levels(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const Limits& limits, FlatSurface& surface) {
  PatchGrid grid = patches_of(points, surface);
  const int off = mark_off(grid.patches, std::max(limits.noise, 0.005));
  if (off < std::max(static_cast<double>(fewest), smallest_share * static_cast<double>(surface.members.size()))) return false;
  FlatSurface rest = surface;
  for (Mask& mask : rest.masks) uncover(mask, grid, surface.plane);
  const auto gone = [&](std::uint32_t i) {
    const Patch* patch = grid.at(points.position(i));
    return patch && patch->off;
  };
  rest.members.erase(std::remove_if(rest.members.begin(), rest.members.end(), gone), rest.members.end());
  if (rest.members.size() < 3 || !fit_trimmed(points, viewpoints, limits, rest)) return false;
  surface = std::move(rest);
  return true;
}

}  // namespace sgraph
