#include "sgraph_slam/core/sim/scene.hpp"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "sgraph_slam/core/math/signed_area.hpp"

namespace sgraph::sim {

namespace {

struct Triangle {
  std::array<std::uint32_t, 3> corner;
  std::size_t surface;
};

bool inside(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const auto side = [&](const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
    return (v.x() - u.x()) * (p.y() - u.y()) - (v.y() - u.y()) * (p.x() - u.x());
  };
  return side(a, b) >= 0 && side(b, c) >= 0 && side(c, a) >= 0;
}

// Triangles of a simple polygon, by cutting ears off.
std::vector<std::array<std::size_t, 3>> triangulate(const std::vector<Eigen::Vector3d>& outline) {
  std::vector<std::array<std::size_t, 3>> triangles;
  if (outline.size() == 4) return {{0, 1, 2}, {0, 2, 3}};
  const Eigen::Vector3d x = (outline[1] - outline[0]).normalized();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < outline.size(); ++i) normal += outline[i].cross(outline[(i + 1) % outline.size()]);
  const Eigen::Vector3d y = normal.normalized().cross(x);
  std::vector<Eigen::Vector2d> flat;
  for (const Eigen::Vector3d& p : outline) flat.emplace_back(p.dot(x), p.dot(y));
  std::vector<std::size_t> left(outline.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  while (left.size() > 3) {
    bool cut = false;
    for (std::size_t i = 0; i < left.size() && !cut; ++i) {
      const std::size_t a = left[(i + left.size() - 1) % left.size()];
      const std::size_t b = left[i];
      const std::size_t c = left[(i + 1) % left.size()];
      if (signed_area({flat[a], flat[b], flat[c]}) <= 0) continue;
      bool ear = true;
      for (const std::size_t other : left) ear = ear && (other == a || other == b || other == c || !inside(flat[other], flat[a], flat[b], flat[c]));
      if (!ear) continue;
      triangles.push_back({a, b, c});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      cut = true;
    }
    if (!cut) throw WorldError("an outline crosses itself");
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

}  // namespace

class Scene::Implementation {
 public:
  explicit Implementation(std::vector<Surface> surfaces) : surfaces_(std::move(surfaces)), device_(rtcNewDevice("threads=1")) {
    if (device_ == nullptr) throw std::runtime_error("Embree gives no device");
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Triangle> triangles;
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
      const auto base = static_cast<std::uint32_t>(vertices.size());
      for (const Eigen::Vector3d& p : surfaces_[s].outline) vertices.push_back(p.cast<float>());
      for (const auto& t : triangulate(surfaces_[s].outline)) {
        triangles.push_back(
            {{base + static_cast<std::uint32_t>(t[0]), base + static_cast<std::uint32_t>(t[1]), base + static_cast<std::uint32_t>(t[2])}, s});
      }
    }
    attach(vertices, triangles);
  }

  ~Implementation() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  [[nodiscard]] HitPacket cast(const RayPacket& rays) const {
    RTCRayHit16 q;
    alignas(64) int valid[packet_size];
    for (std::size_t i = 0; i < packet_size; ++i) {
      valid[i] = rays.active[i] ? -1 : 0;
      const Eigen::Vector3f o = rays.origin[i].cast<float>();
      const Eigen::Vector3f d = rays.direction[i].cast<float>();
      q.ray.org_x[i] = o.x();
      q.ray.org_y[i] = o.y();
      q.ray.org_z[i] = o.z();
      q.ray.dir_x[i] = d.x();
      q.ray.dir_y[i] = d.y();
      q.ray.dir_z[i] = d.z();
      q.ray.tnear[i] = static_cast<float>(rays.begin[i]);
      q.ray.tfar[i] = std::numeric_limits<float>::infinity();
      q.ray.time[i] = 0;
      q.ray.mask[i] = 0xFFFFFFFFU;
      q.ray.id[i] = 0;
      q.ray.flags[i] = 0;
      q.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      q.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect16(valid, scene_, &context, &q);
    return read(rays, q);
  }

 private:
  void attach(const std::vector<Eigen::Vector3f>& vertices, const std::vector<Triangle>& triangles) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* v =
        static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices.size()));
    auto* t = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
    if (v == nullptr || t == nullptr) throw std::runtime_error("Embree can't hold the world");
    for (const Eigen::Vector3f& p : vertices) {
      for (int k = 0; k < 3; ++k) *v++ = p[k];
    }
    for (const Triangle& triangle : triangles) {
      for (const std::uint32_t corner : triangle.corner) *t++ = corner;
      owner_.push_back(triangle.surface);
      const Eigen::Vector3d a = vertices[triangle.corner[0]].cast<double>();
      const Eigen::Vector3d b = vertices[triangle.corner[1]].cast<double>();
      const Eigen::Vector3d c = vertices[triangle.corner[2]].cast<double>();
      normal_.push_back((b - a).cross(c - a).normalized());
      offset_.push_back(normal_.back().dot(surfaces_[triangle.surface].outline.front()));
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }

  // The distance is computed again in double precision from the triangle's plane: in float it is good to 1e-7 of the coordinates only.
  [[nodiscard]] HitPacket read(const RayPacket& rays, const RTCRayHit16& q) const {
    HitPacket hits;
    for (std::size_t i = 0; i < packet_size; ++i) {
      hits.distance[i] = std::numeric_limits<double>::infinity();
      if (!rays.active[i] || q.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const std::size_t triangle = q.hit.primID[i];
      const double across = normal_[triangle].dot(rays.direction[i]);
      hits.cosine[i] = std::min(1.0, std::abs(across));
      hits.surface[i] = &surfaces_[owner_[triangle]];
      hits.normal[i] = normal_[triangle];
      hits.distance[i] =
          std::abs(across) > 1e-6 ? (offset_[triangle] - normal_[triangle].dot(rays.origin[i])) / across : static_cast<double>(q.ray.tfar[i]);
    }
    return hits;
  }

  std::vector<Surface> surfaces_;
  RTCDevice device_;
  RTCScene scene_ = nullptr;
  std::vector<std::size_t> owner_;       // surface of each triangle
  std::vector<Eigen::Vector3d> normal_;  // plane of each triangle
  std::vector<double> offset_;
};

Scene::Scene(std::vector<Surface> surfaces) : implementation_(std::make_unique<Implementation>(std::move(surfaces))) {}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

HitPacket Scene::cast(const RayPacket& rays) const { return implementation_->cast(rays); }

}  // namespace sgraph::sim
