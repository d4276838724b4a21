#include "sgraph_slam/core/eval/wall_faces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace sgraph {
namespace {

constexpr double step = 0.1;          // between samples along a face [m]
constexpr double pose_spacing = 0.3;  // between the viewpoints tried [m]
constexpr double eye_height = 0.7;    // a LiDAR's above the floor: openings there let the view through [m]
constexpr double off_surface = 0.02;  // the sample is looked at from a little in front of the surface [m]

// A stretch of a wall's body as a flat rectangle along the wall.
struct Body {
  Eigen::Vector2d origin;
  Eigen::Vector2d along;
  double begin;
  double end;
  double half;
  double bottom;

  // Coordinates along and across.
  [[nodiscard]] Eigen::Vector2d local(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d r = p - origin;
    return {along.dot(r), along.x() * r.y() - along.y() * r.x()};
  }
  [[nodiscard]] bool contains(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d l = local(p);
    return l.x() > begin && l.x() < end && std::abs(l.y()) < half;
  }
  // Whether the line from a to b passes through (slab test).
  [[nodiscard]] bool blocks(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    const Eigen::Vector2d p = local(a);
    const Eigen::Vector2d v = local(b) - p;
    const Eigen::Vector2d low(begin, -half);
    const Eigen::Vector2d high(end, half);
    double enter = 0;
    double leave = 1;
    for (int i = 0; i < 2; ++i) {
      if (std::abs(v[i]) < 1e-12) {
        if (p[i] <= low[i] || p[i] >= high[i]) return false;
        continue;
      }
      const double t1 = (low[i] - p[i]) / v[i];
      const double t2 = (high[i] - p[i]) / v[i];
      enter = std::max(enter, std::min(t1, t2));
      leave = std::min(leave, std::max(t1, t2));
    }
    return enter < leave;
  }
};

bool lets_through(const PlanOpening& o) { return o.bottom < eye_height && o.top > eye_height; }

// What of the walls stands in the way of a horizontal view; whole bodies when `with_openings` is off.
std::vector<Body> bodies_of(const PlanWall& wall, bool with_openings) {
  std::vector<Body> bodies;
  const double half = std::max(wall.thickness / 2, 0.005);
  double begin = -wall.extend_p;
  const auto add = [&](double from, double to) {
    if (to > from) bodies.push_back({wall.p, wall.direction(), from, to, half, wall.bottom});
  };
  for (const PlanOpening& o : wall.openings) {
    if (!with_openings || !lets_through(o)) continue;
    add(begin, o.begin);
    begin = std::max(begin, o.end);
  }
  add(begin, wall.length() + wall.extend_q);
  return bodies;
}

struct Scene {
  std::vector<Body> solid;  // opaque at eye height
  std::vector<Body> whole;  // of every opaque wall, openings closed
  std::vector<Eigen::Vector3d> eyes;
};

Scene scene_of(const Plan& plan, const std::vector<Pose>& T_truth_base) {
  Scene scene;
  for (const PlanWall& wall : plan.walls) {
    if (wall.glass || wall.height < eye_height) continue;
    for (const Body& b : bodies_of(wall, true)) scene.solid.push_back(b);
    for (const Body& b : bodies_of(wall, false)) scene.whole.push_back(b);
  }
  for (const Pose& pose : T_truth_base) {
    if (scene.eyes.empty() || (pose.translation - scene.eyes.back()).norm() >= pose_spacing) scene.eyes.push_back(pose.translation);
  }
  return scene;
}

bool seen(const Scene& scene, const Eigen::Vector2d& surface, const WallFace& face, double range) {
  const Eigen::Vector2d p = surface + off_surface * face.normal;
  const double least_sine = std::sin(10 * M_PI / 180);
  return std::any_of(scene.eyes.begin(), scene.eyes.end(), [&](const Eigen::Vector3d& eye) {
    if (eye.z() < face.bottom - 0.5 || eye.z() > face.bottom + 2.5) return false;  // on another storey
    const Eigen::Vector2d ray = eye.head<2>() - p;
    const double distance = ray.norm();
    if (distance > range || face.normal.dot(ray) < least_sine * distance) return false;
    return std::none_of(scene.solid.begin(), scene.solid.end(), [&](const Body& b) { return b.blocks(p, eye.head<2>()); });
  });
}

bool in_hole(const PlanWall& wall, double along) {
  return std::any_of(wall.openings.begin(), wall.openings.end(),
                     [along](const PlanOpening& o) { return lets_through(o) && along > o.begin && along < o.end; });
}

// The pieces of one side of a wall; `side` is +1 at the left hand of p -> q, -1 at the right.
void add_faces(const PlanWall& wall, std::size_t index, double side, const Scene& scene, double range, std::vector<WallFace>& faces) {
  const Eigen::Vector2d along = wall.direction();
  const Eigen::Vector2d normal = side * Eigen::Vector2d(-along.y(), along.x());
  const int samples = std::max(1, static_cast<int>(std::lround(wall.length() / step)));
  const double width = wall.length() / samples;
  const auto surface = [&](double s) -> Eigen::Vector2d { return wall.p + s * along + 0.5 * wall.thickness * normal; };
  std::optional<WallFace> face;
  const auto close = [&](double s) {
    if (!face) return;
    face->end = surface(s);
    faces.push_back(*face);
    face.reset();
  };
  for (int i = 0; i < samples; ++i) {
    const double s = (i + 0.5) * width;
    const Eigen::Vector2d in_front = surface(s) + off_surface * normal;
    if (std::any_of(scene.whole.begin(), scene.whole.end(), [&](const Body& b) { return b.bottom == wall.bottom && b.contains(in_front); })) {
      close(s - 0.5 * width);
      continue;
    }
    if (!face) {
      face = WallFace{};
      face->wall = index;
      face->normal = normal;
      face->bottom = wall.bottom;
      face->begin = surface(s - 0.5 * width);
    }
    if (in_hole(wall, s) || !seen(scene, surface(s), *face, range)) continue;
    const double from_begin = along.dot(surface(s) - face->begin);
    if (face->seen_length == 0) face->seen_begin = from_begin - 0.5 * width;
    face->seen_end = from_begin + 0.5 * width;
    face->seen_length += width;
  }
  close(wall.length());
}

}  // namespace

std::vector<WallFace> wall_faces(const Plan& plan, const std::vector<Pose>& T_truth_base, double range) {
  const Scene scene = scene_of(plan, T_truth_base);
  std::vector<WallFace> faces;
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    if (plan.walls[i].glass || plan.walls[i].height < eye_height) continue;
    for (const double side : {1.0, -1.0}) add_faces(plan.walls[i], i, side, scene, range, faces);
  }
  return faces;
}

}  // namespace sgraph
