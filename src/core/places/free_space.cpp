#include "sgraph_slam/core/places/free_space.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "sgraph_slam/core/math/walk_cells.hpp"
#include "sgraph_slam/core/util/scattered_order.hpp"

namespace sgraph {
namespace {

constexpr double end_unit = 0.005;  // of a ray's end [m]: a quarter of the range noise
constexpr double spot = 0.5;        // keyframes no further apart than this see the same [m]:
constexpr std::size_t at_spot = 8;  // enough of them to outvote a person who stood in the way in a few
constexpr double growth = 10;       // the raster grows by whole steps of this [m]
constexpr std::uint8_t low_bit = 1;
constexpr std::uint8_t mid_bit = 2;
constexpr std::uint8_t high_bit = 4;
constexpr std::uint8_t over_bit = 8;
constexpr std::uint8_t hit_bit = 16;
constexpr std::uint8_t hit_over_bit = 32;

// Where the LiDAR was when a point was measured: between the viewpoints around its time.
std::uint16_t viewpoint_of(const std::vector<Viewpoint>& viewpoints, double time) {
  if (viewpoints.size() < 2) return 0;
  const auto next = std::lower_bound(viewpoints.begin(), viewpoints.end(), time, [](const Viewpoint& v, double t) { return v.time < t; });
  if (next == viewpoints.begin()) return 0;
  if (next == viewpoints.end()) return static_cast<std::uint16_t>(viewpoints.size() - 1);
  const auto before = next - 1;
  return static_cast<std::uint16_t>((time - before->time < next->time - time ? before : next) - viewpoints.begin());
}

}  // namespace

FreeSpace::FreeSpace(const FreeSpace& other)
    : params_(other.params_),
      rays_(other.rays_),
      marks_(other.marks_),
      first_(other.first_),
      origin_(other.origin_),
      floor_z_(other.floor_z_),
      size_to_make_(other.width_ > 0 ? Eigen::Vector2i(other.width_, other.height_) : other.size_to_make_) {}

void FreeSpace::add(KeyframeId id, const Cloud& cloud, const Pose& T_base_lidar) {
  if (cloud.empty() || rays_.count(id) > 0) return;
  Rays kept;
  for (const Viewpoint& viewpoint : cloud.viewpoints) kept.viewpoints.push_back((T_base_lidar * viewpoint.position).cast<float>());
  if (kept.viewpoints.empty()) kept.viewpoints.push_back(T_base_lidar.translation.cast<float>());
  const auto most = static_cast<std::size_t>(params_.rays);
  kept.rays.reserve(std::min(most, cloud.size()));
  const double reach = end_unit * std::numeric_limits<std::int16_t>::max();
  visit_scattered(cloud.size(), [&](std::size_t i) {
    if (kept.rays.size() >= most) return;
    const Point& point = cloud.points[i];
    const Eigen::Vector3d end = T_base_lidar * point.position().cast<double>();
    if (!end.allFinite() || end.cwiseAbs().maxCoeff() >= reach) return;
    const auto unit = [](double value) { return static_cast<std::int16_t>(std::lround(value / end_unit)); };
    kept.rays.push_back({unit(end.x()), unit(end.y()), unit(end.z()), viewpoint_of(cloud.viewpoints, point.time)});
  });
  rays_[id] = std::make_shared<const Rays>(std::move(kept));
}

std::vector<Eigen::Vector3d> FreeSpace::ends_near(const Eigen::Vector2d& p, double keyframes_within, double ends_within) const {
  std::vector<Eigen::Vector3d> ends;
  for (const auto& [id, mark] : marks_) {
    const Eigen::Vector3d& here = mark.T_map_base.translation;
    if ((here.head<2>() - p).norm() > keyframes_within) continue;
    const Eigen::Matrix3d R = mark.T_map_base.rotation.toRotationMatrix();
    for (const Ray& ray : rays_.at(id)->rays) {
      const Eigen::Vector3d end = R * (end_unit * Eigen::Vector3d(ray.x, ray.y, ray.z)) + here;
      if ((end.head<2>() - p).squaredNorm() <= ends_within * ends_within) ends.push_back(end);
    }
  }
  return ends;
}

const FreeCell& FreeSpace::at(const Eigen::Vector2d& p) const {
  static const FreeCell none;
  const Eigen::Vector2d cell = (p / params_.resolution).array().floor().matrix() - first_.cast<double>();
  if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < width_ && cell.y() < height_)) return none;
  return cells_[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(cell.x())];
}

void FreeSpace::make_room(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const double block = growth / params_.resolution;
  Eigen::Vector2i first = (static_cast<int>(block) * (low / growth).array().floor()).cast<int>();
  Eigen::Vector2i last = (static_cast<int>(block) * (high / growth).array().ceil()).cast<int>();
  if (width_ > 0) {
    first = first.cwiseMin(first_);
    last = last.cwiseMax(first_ + Eigen::Vector2i(width_, height_));
  }
  lay_out(first, last - first);
}

// Makes the raster one that begins at a cell and has a size, with what it holds.
void FreeSpace::lay_out(const Eigen::Vector2i& first, const Eigen::Vector2i& size) {
  if (width_ > 0 && first == first_ && size == Eigen::Vector2i(width_, height_)) return;
  std::vector<FreeCell> cells(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()));
  for (int y = 0; y < height_; ++y) {
    const auto from = cells_.begin() + static_cast<std::ptrdiff_t>(y) * width_;
    std::copy(from, from + width_, cells.begin() + static_cast<std::ptrdiff_t>(y + first_.y() - first.y()) * size.x() + first_.x() - first.x());
  }
  cells_ = std::move(cells);
  first_ = first;
  origin_ = params_.resolution * first.cast<double>();
  width_ = size.x();
  height_ = size.y();
  free_ = CellBits(width_, height_);
  for (int y = 0; y < height_; ++y) {
    const FreeCell* row = cells_.data() + static_cast<std::ptrdiff_t>(y) * width_;
    free_.set_row(y, 0, width_, [row](int x) { return row[x].free(); });
  }
}

struct FreeSpace::Sweep {
  Eigen::Vector2i first;  // its lower left cell, counted from the map's origin
  int width;              // a multiple of eight
  int height;
  std::vector<std::uint8_t>& bits;  // row by row

  Sweep(const Eigen::Vector2i& low, const Eigen::Vector2i& high, std::vector<std::uint8_t>& memory)
      : first(low), width((high.x() - low.x() + 8) / 8 * 8), height(high.y() - low.y() + 1), bits(memory) {
    bits.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  }
};

void FreeSpace::trace(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double floor_z, Sweep& sweep) const {
  const double cell_size = params_.resolution;
  const Eigen::Vector2d a = from.head<2>() / cell_size;  // on one lattice whatever the raster holds: marks are taken back exactly
  const Eigen::Vector2d way = (to - from).head<2>() / cell_size;
  const double length = way.norm() * cell_size;
  if (length < cell_size) return;
  // The part of the ray that counts: within reach, above the ankle.
  double leave = std::min(1.0, params_.reach / length);
  double enter = 0;
  const double low = floor_z + params_.ankle - from.z();
  const double rise = to.z() - from.z();
  if (rise > 1e-9) {
    enter = std::max(enter, low / rise);
  } else if (rise < -1e-9) {
    leave = std::min(leave, low / rise);
  } else if (low > 0) {
    return;
  }
  if (enter >= leave) return;
  const bool hit = leave >= 1;
  const Eigen::Vector2d first = sweep.first.cast<double>();
  const Eigen::Vector2d begin = a + enter * way - first;
  const Eigen::Vector2d end = a + leave * way - first;
  // Twice the part of the way at which the ray rises, or falls, through each height: its bits change there.
  const bool rises = rise > -1e-9;
  std::array<std::int64_t, 3> passes{};
  for (std::size_t k = 0; k < passes.size(); ++k) {
    const double height = floor_z + (k == 0 ? params_.sill : k == 1 ? params_.shelf : params_.head) - from.z();
    const double at = (height / rise - enter) / (leave - enter);  // not finite for a level ray: it is above or below all along
    const double never = height > 0 ? 2 : -1;
    passes[k] = static_cast<std::int64_t>(std::clamp(std::abs(rise) < 1e-9 ? never : at, -1.0, 2.0) * static_cast<double>(2 * whole_way));
  }
  if (!rises) std::swap(passes.front(), passes.back());
  std::uint8_t* bits = sweep.bits.data();
  const auto bit_at = [rises](std::size_t heights) { return static_cast<std::uint8_t>(low_bit << (rises ? heights : 3 - heights)); };
  const std::array<std::uint8_t, 4> bit{bit_at(0), bit_at(1), bit_at(2), bit_at(3)};
  walk_stretches(begin, end, {1, sweep.width}, passes,
                 [&](std::ptrdiff_t cell, std::size_t passed) { bits[cell] = static_cast<std::uint8_t>(bits[cell] | bit[passed]); });
  if (!hit) return;
  const Eigen::Vector2i last = end.array().floor().cast<int>();
  std::uint8_t& cell = bits[last.y() * static_cast<std::ptrdiff_t>(sweep.width) + last.x()];
  cell = static_cast<std::uint8_t>(cell | (rise < floor_z + params_.head - from.z() ? hit_bit : hit_over_bit));
}

void FreeSpace::mark(const Rays& rays, const Mark& at, int sign) {
  std::vector<Eigen::Vector3d> from;
  for (const Eigen::Vector3f& viewpoint : rays.viewpoints) from.push_back(at.T_map_base * viewpoint.cast<double>());
  const Eigen::Matrix3d R = at.T_map_base.rotation.toRotationMatrix();
  const auto end_of = [&](const Ray& ray) -> Eigen::Vector3d {
    return R * (end_unit * Eigen::Vector3d(ray.x, ray.y, ray.z)) + at.T_map_base.translation;
  };
  Eigen::AlignedBox2d box;
  for (const Ray& ray : rays.rays) {
    const Eigen::Vector3d& begin = from[ray.viewpoint];
    const Eigen::Vector2d way = (end_of(ray) - begin).head<2>();
    box.extend(begin.head<2>().eval()).extend((begin.head<2>() + std::min(1.0, params_.reach / std::max(way.norm(), 1e-9)) * way).eval());
  }
  if (box.isEmpty()) return;
  const double margin = 2 * params_.resolution;
  const Eigen::Vector2d low = box.min().array() - margin;
  const Eigen::Vector2d high = box.max().array() + margin;
  make_room(low, high);
  const auto cell_of = [this](const Eigen::Vector2d& p) -> Eigen::Vector2i { return (p / params_.resolution).array().floor().cast<int>(); };
  Sweep sweep(cell_of(low), cell_of(high), scratch_);
  for (const Ray& ray : rays.rays) trace(from[ray.viewpoint], end_of(ray), at.floor_z, sweep);
  count(sweep, sign);
}

// Adds the keyframe's marks to the raster's cells, or takes them away.
void FreeSpace::count(const Sweep& sweep, int sign) {
  const auto add = [sign](std::uint16_t& value, int once) { value = static_cast<std::uint16_t>(value + sign * once); };
  for (int y = 0; y < sweep.height; ++y) {
    const std::uint8_t* bits = sweep.bits.data() + static_cast<std::ptrdiff_t>(y) * sweep.width;
    const int row = y + sweep.first.y() - first_.y();
    const int column = sweep.first.x() - first_.x();
    for (int begin = 0; begin < sweep.width; begin += 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, bits + begin, sizeof eight);
      if (eight == 0) continue;
      for (int x = begin; x < begin + 8; ++x) {
        const int seen = bits[x];
        if (seen == 0) continue;
        FreeCell& cell = cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column + x)];
        if ((seen & over_bit) != 0 && (seen & hit_over_bit) == 0) add(cell.over, 1);
        // A cell with a surface is not free to this keyframe, whatever passed beside the surface within it.
        if ((seen & hit_bit) != 0) {
          add(cell.hits, 1);
        } else {
          add(cell.low, (seen & low_bit) != 0 ? 1 : 0);
          add(cell.mid, (seen & mid_bit) != 0 ? 1 : 0);
          add(cell.high, (seen & high_bit) != 0 ? 1 : 0);
        }
        free_.put(column + x, row, cell.free());
      }
    }
  }
}

// Of a copy, which has none yet.
void FreeSpace::make_raster() {
  if (size_to_make_.x() == 0) return;
  lay_out(first_, std::exchange(size_to_make_, Eigen::Vector2i::Zero()));
  for (const auto& [id, mark] : marks_) this->mark(*rays_.at(id), mark, 1);
}

void FreeSpace::mark_ahead(const std::function<const Pose*(KeyframeId)>& pose_of, int most) {
  make_raster();
  if (width_ == 0) return;
  std::vector<KeyframeId> chosen;
  for (const auto& [id, rays] : rays_) {
    if (static_cast<int>(chosen.size()) == most) break;
    if (marks_.count(id) == 0 && pose_of(id) != nullptr) chosen.push_back(id);
  }
  for (const KeyframeId id : chosen) {
    const Mark mark{*pose_of(id), floor_z_};
    this->mark(*rays_.at(id), mark, 1);
    marks_[id] = mark;
    thin_spot(id);
  }
}

void FreeSpace::update(const std::map<KeyframeId, Pose>& T_map_base, double floor_z) {
  floor_z_ = floor_z;
  make_raster();
  const double moved = 0.5 * params_.resolution;
  const double turned = moved / 5;  // half a cell at five metres
  std::vector<KeyframeId> fresh;
  for (const auto& [id, rays] : rays_) {
    const auto pose = T_map_base.find(id);
    const auto known = marks_.find(id);
    const bool known_before = known != marks_.end();
    if (known_before) {
      const Mark& mark = known->second;
      const bool same = pose != T_map_base.end() && (pose->second.translation - mark.T_map_base.translation).norm() <= moved &&
                        pose->second.rotation.angularDistance(mark.T_map_base.rotation) <= turned && std::abs(floor_z - mark.floor_z) <= moved;
      if (same) continue;
      this->mark(*rays, mark, -1);
      marks_.erase(known);
    }
    if (pose == T_map_base.end()) continue;
    const Mark mark{pose->second, floor_z};
    this->mark(*rays, mark, 1);
    marks_[id] = mark;
    if (!known_before) fresh.push_back(id);
  }
  for (const KeyframeId id : fresh) thin_spot(id);
}

// Lets the oldest keyframes around one go, so that what was seen last stays.
void FreeSpace::thin_spot(KeyframeId newest) {
  const auto at = marks_.find(newest);
  if (at == marks_.end()) return;
  const Eigen::Vector3d here = at->second.T_map_base.translation;
  std::vector<KeyframeId> around;
  for (const auto& [id, mark] : marks_) {
    if ((mark.T_map_base.translation - here).squaredNorm() <= spot * spot) around.push_back(id);
  }
  for (std::size_t i = 0; i + at_spot < around.size(); ++i) {
    mark(*rays_.at(around[i]), marks_.at(around[i]), -1);
    marks_.erase(around[i]);
    rays_.erase(around[i]);
  }
}

}  // namespace sgraph
