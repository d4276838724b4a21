#include "regions.hpp"

#include <geos_c.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "plan.hpp"
#include "sgraph_slam/core/math/signed_area.hpp"
#include "yaml_fields.hpp"

namespace sgraph::sim {

namespace {

using Ring = std::vector<Eigen::Vector2d>;

// GEOS by its C interface: a context a call, and geometries that are freed.
class Geos {
 public:
  Geos() : context_(GEOS_init_r()) {}
  ~Geos() { GEOS_finish_r(context_); }
  Geos(const Geos&) = delete;
  Geos& operator=(const Geos&) = delete;

  struct Deleter {
    GEOSContextHandle_t context;
    void operator()(GEOSGeometry* geometry) const { GEOSGeom_destroy_r(context, geometry); }
  };
  using Geometry = std::unique_ptr<GEOSGeometry, Deleter>;

  [[nodiscard]] Geometry own(GEOSGeometry* geometry) const {
    if (geometry == nullptr) throw WorldError("GEOS gives no result for a storey's walls");
    return {geometry, Deleter{context_}};
  }

  [[nodiscard]] Geometry polygon(const Ring& ring) const {
    GEOSCoordSequence* sequence = GEOSCoordSeq_create_r(context_, static_cast<unsigned>(ring.size() + 1), 2);
    for (unsigned i = 0; i <= ring.size(); ++i) {
      const Eigen::Vector2d& p = ring[i % ring.size()];
      GEOSCoordSeq_setXY_r(context_, sequence, i, p.x(), p.y());
    }
    return own(GEOSGeom_createPolygon_r(context_, GEOSGeom_createLinearRing_r(context_, sequence), nullptr, 0));
  }

  [[nodiscard]] Geometry united(std::vector<Geometry> parts) const {
    std::vector<GEOSGeometry*> raw;
    for (Geometry& part : parts) raw.push_back(part.release());
    const Geometry all = own(GEOSGeom_createCollection_r(context_, GEOS_MULTIPOLYGON, raw.data(), static_cast<unsigned>(raw.size())));
    return own(GEOSUnaryUnionPrec_r(context_, all.get(), 1e-6));
  }

  // Grown or, with a negative distance, shrunk with square corners.
  [[nodiscard]] Geometry grown(const GEOSGeometry* geometry, double distance) const {
    return own(GEOSBufferWithStyle_r(context_, geometry, distance, 4, GEOSBUF_CAP_FLAT, GEOSBUF_JOIN_MITRE, 8));
  }

  [[nodiscard]] Ring ring_of(const GEOSGeometry* ring) const {
    const GEOSCoordSequence* sequence = GEOSGeom_getCoordSeq_r(context_, ring);
    unsigned size = 0;
    GEOSCoordSeq_getSize_r(context_, sequence, &size);
    Ring points;
    for (unsigned i = 0; i + 1 < size; ++i) {
      double x = 0;
      double y = 0;
      GEOSCoordSeq_getXY_r(context_, sequence, i, &x, &y);
      points.emplace_back(x, y);
    }
    return points;
  }

  [[nodiscard]] GEOSContextHandle_t context() const { return context_; }

 private:
  GEOSContextHandle_t context_;
};

// Counter-clockwise, without corners that lie on the line between their neighbours, from the lowest of the leftmost corners.
Ring tidy(Ring ring) {
  if (signed_area(ring) < 0) std::reverse(ring.begin(), ring.end());
  bool changed = true;
  while (changed && ring.size() > 3) {
    changed = false;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d& a = ring[(i + ring.size() - 1) % ring.size()];
      const Eigen::Vector2d& c = ring[(i + 1) % ring.size()];
      const Eigen::Vector2d u = c - a;
      const Eigen::Vector2d v = ring[i] - a;
      if (std::abs(u.x() * v.y() - u.y() * v.x()) > 1e-3 * std::max(u.norm(), 1e-9)) continue;
      ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
      changed = true;
      break;
    }
  }
  const auto first = std::min_element(ring.begin(), ring.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::abs(a.x() - b.x()) > 1e-6 ? a.x() < b.x() : a.y() < b.y();
  });
  std::rotate(ring.begin(), first, ring.end());
  return ring;
}

bool within(const Ring& ring, const Eigen::Vector2d& p) {
  bool in = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d& a = ring[i];
    const Eigen::Vector2d& b = ring[(i + 1) % ring.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) in = !in;
  }
  return in;
}

double distance_to_edge(const Ring& ring, const Eigen::Vector2d& p) {
  double nearest = 1e9;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d edge = ring[(i + 1) % ring.size()] - ring[i];
    const double f = std::min(1.0, std::max(0.0, (p - ring[i]).dot(edge) / std::max(edge.squaredNorm(), 1e-12)));
    nearest = std::min(nearest, (p - ring[i] - f * edge).norm());
  }
  return nearest;
}

// The wall's body on the floor, its doors and windows filled, at half height; in pieces where it is bowed or an opening joins.
std::vector<Ring> bodies(const Wall& wall) {
  constexpr double pane = 0.01;
  constexpr int pieces = 6;
  std::vector<std::pair<double, double>> closed;
  double at = -wall.extend_p;
  for (const Opening& opening : wall.openings) {
    if (!opening.joins) continue;
    if (opening.begin > at) closed.emplace_back(at, opening.begin);
    at = opening.end;
  }
  if (wall.length() + wall.extend_q > at) closed.emplace_back(at, wall.length() + wall.extend_q);
  const Eigen::Vector2d along = wall.direction();
  const Eigen::Vector2d left(-along.y(), along.x());
  const double half = 0.5 * (wall.glass ? pane : wall.thickness);
  std::vector<Ring> all;
  for (const auto& [begin, end] : closed) {
    const int count = wall.bow == 0 ? 1 : pieces;
    Ring right_side;
    Ring left_side;
    for (int i = 0; i <= count; ++i) {
      const double s = begin + (end - begin) * i / count;
      const double share = 2 * s / wall.length() - 1;
      const Eigen::Vector2d center = wall.p + s * along + wall.bow * std::max(0.0, 1 - share * share) * left;
      right_side.emplace_back(center - half * left);
      left_side.emplace_back(center + half * left);
    }
    right_side.insert(right_side.end(), left_side.rbegin(), left_side.rend());
    all.push_back(right_side);
  }
  return all;
}

std::vector<Region> enclosed(const Storey& storey) {
  constexpr double sliver = 0.02;       // gaps between walls up to twice this are closed [m]
  constexpr double least_area = 1.0;    // of a place [m^2]
  constexpr double least_island = 1.0;  // of what stands in it and counts as a hole [m^2]
  constexpr double bounding_height = 1.8;
  const Geos geos;
  std::vector<Geos::Geometry> parts;
  for (const Wall& wall : storey.walls) {
    if (wall.height < bounding_height) continue;
    for (const Ring& body : bodies(wall)) parts.push_back(geos.polygon(body));
  }
  if (parts.empty()) return {};
  const Geos::Geometry walls = geos.grown(geos.united(std::move(parts)).get(), sliver);
  // What the walls leave of a rectangle around them: the piece at its rim is outdoors.
  double low_x = 0;
  double low_y = 0;
  double high_x = 0;
  double high_y = 0;
  GEOSGeom_getXMin_r(geos.context(), walls.get(), &low_x);
  GEOSGeom_getYMin_r(geos.context(), walls.get(), &low_y);
  GEOSGeom_getXMax_r(geos.context(), walls.get(), &high_x);
  GEOSGeom_getYMax_r(geos.context(), walls.get(), &high_y);
  const Geos::Geometry around = geos.polygon({{low_x - 1, low_y - 1}, {high_x + 1, low_y - 1}, {high_x + 1, high_y + 1}, {low_x - 1, high_y + 1}});
  const Geos::Geometry free = geos.own(GEOSDifference_r(geos.context(), around.get(), walls.get()));
  std::vector<Region> regions;
  for (int i = 0; i < GEOSGetNumGeometries_r(geos.context(), free.get()); ++i) {
    const GEOSGeometry* piece = GEOSGetGeometryN_r(geos.context(), free.get(), i);
    double piece_low_x = 0;
    GEOSGeom_getXMin_r(geos.context(), piece, &piece_low_x);
    if (piece_low_x < low_x) continue;
    const Geos::Geometry grown = geos.grown(piece, sliver);
    for (int n = 0; n < GEOSGetNumGeometries_r(geos.context(), grown.get()); ++n) {
      const GEOSGeometry* floor = GEOSGetGeometryN_r(geos.context(), grown.get(), n);
      Region region;
      GEOSArea_r(geos.context(), floor, &region.area);
      if (region.area < least_area) continue;
      region.outline = tidy(geos.ring_of(GEOSGetExteriorRing_r(geos.context(), floor)));
      for (int h = 0; h < GEOSGetNumInteriorRings_r(geos.context(), floor); ++h) {
        const Ring island = tidy(geos.ring_of(GEOSGetInteriorRingN_r(geos.context(), floor, h)));
        if (std::abs(signed_area(island)) >= least_island) region.holes.push_back(island);
      }
      regions.push_back(region);
    }
  }
  std::sort(regions.begin(), regions.end(), [](const Region& a, const Region& b) {
    const Eigen::Vector2d& p = a.outline.front();
    const Eigen::Vector2d& q = b.outline.front();
    return std::abs(p.x() - q.x()) > 1e-6 ? p.x() < q.x() : p.y() < q.y();
  });
  return regions;
}

}  // namespace

int region_at(const std::vector<Region>& regions, const Eigen::Vector2d& at, double margin) {
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const Region& region = regions[i];
    if (!within(region.outline, at) || distance_to_edge(region.outline, at) < margin) continue;
    const bool in_hole = std::any_of(region.holes.begin(), region.holes.end(),
                                     [&](const Ring& hole) { return within(hole, at) || distance_to_edge(hole, at) < margin; });
    if (!in_hole) return static_cast<int>(i);
  }
  return -1;
}

std::vector<Region> regions_of(const Storey& storey, const std::string& file) {
  std::vector<Region> found = enclosed(storey);
  std::vector<Region> named;
  std::vector<int> number(found.size(), -1);
  for (const PlaceSeed& seed : storey.seeds) {
    const int at = region_at(found, seed.at);
    if (at < 0) {
      if (seed.needs_region) fail_at(file, seed.line, seed.name + ": no walls enclose it");
      continue;
    }
    int& index = number[static_cast<std::size_t>(at)];
    if (index >= 0) {
      named[static_cast<std::size_t>(index)].name += "+" + seed.name;
      continue;
    }
    index = static_cast<int>(named.size());
    named.push_back(found[static_cast<std::size_t>(at)]);
    named.back().name = seed.name;
    named.back().kind = seed.kind;
  }
  int unnamed = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (number[i] >= 0) continue;
    found[i].name = "place " + std::to_string(++unnamed);
    found[i].kind = "room";
    named.push_back(found[i]);
  }
  return named;
}

std::vector<Doorway> doorways_of(const Storey& storey) {
  constexpr double threshold = 0.3;  // an opening whose sill is higher is no door [m]
  constexpr double beyond = 0.15;    // of the wall's face, where the place is looked up [m]
  std::vector<Doorway> doors;
  for (const Wall& wall : storey.walls) {
    const Eigen::Vector2d along = wall.direction();
    const Eigen::Vector2d left(-along.y(), along.x());
    for (const Opening& opening : wall.openings) {
      if (opening.pane || opening.joins || opening.bottom > threshold) continue;
      Doorway door;
      const double middle = 0.5 * (opening.begin + opening.end);
      const double share = 2 * middle / wall.length() - 1;
      door.position = wall.p + middle * along + wall.bow * std::max(0.0, 1 - share * share) * left;
      door.yaw = std::atan2(along.y(), along.x());
      door.width = opening.end - opening.begin;
      door.height = opening.top;
      door.closed = opening.closed;
      door.from = region_at(storey.regions, door.position + (0.5 * wall.thickness + beyond) * left);
      door.to = region_at(storey.regions, door.position - (0.5 * wall.thickness + beyond) * left);
      if (door.from != door.to) doors.push_back(door);
    }
  }
  return doors;
}

}  // namespace sgraph::sim
