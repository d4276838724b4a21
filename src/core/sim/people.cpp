#include "people.hpp"

#include <cmath>
#include <limits>

namespace sgraph::sim {

namespace {

constexpr double none = std::numeric_limits<double>::infinity();

struct Ray {
  const Eigen::Vector3d& origin;
  const Eigen::Vector3d& direction;
};

// Mantle of an upright cylinder.
double cylinder(const Ray& ray, const Eigen::Vector2d& axis, double radius, double bottom, double top, double& cosine) {
  const Eigen::Vector2d d = ray.direction.head<2>();
  const Eigen::Vector2d o = ray.origin.head<2>() - axis;
  const double a = d.squaredNorm();
  const double b = o.dot(d);
  const double c = o.squaredNorm() - radius * radius;
  const double discriminant = b * b - a * c;
  if (a < 1e-12 || discriminant <= 0) return none;
  const double distance = (-b - std::sqrt(discriminant)) / a;
  const double z = ray.origin.z() + distance * ray.direction.z();
  if (distance <= 0 || z < bottom || z > top) return none;
  cosine = std::abs((o + distance * d).dot(d)) / radius;
  return distance;
}

double ball(const Ray& ray, const Eigen::Vector3d& center, double radius, double& cosine) {
  const Eigen::Vector3d o = ray.origin - center;
  const double b = o.dot(ray.direction);
  const double discriminant = b * b - o.squaredNorm() + radius * radius;
  if (discriminant <= 0) return none;
  const double distance = -b - std::sqrt(discriminant);
  if (distance <= 0) return none;
  cosine = std::abs((o + distance * ray.direction).dot(ray.direction)) / radius;
  return distance;
}

}  // namespace

PersonTrack::PersonTrack(const Person& person) : person_(person) {
  for (std::size_t i = 1; i < person.path.size(); ++i) length_ += (person.path[i] - person.path[i - 1]).norm();
}

PersonState PersonTrack::at(double time) const {
  PersonState state;
  state.position = person_.path.front();
  const double walked = person_.offset + person_.speed * time;
  double s = length_ > 0 ? std::fmod(walked, 2 * length_) : 0;
  const bool back = s > length_;
  if (back) s = 2 * length_ - s;
  for (std::size_t i = 1; i < person_.path.size(); ++i) {
    const Eigen::Vector2d leg = person_.path[i] - person_.path[i - 1];
    const double length = leg.norm();
    if (s <= length || i + 1 == person_.path.size()) {
      state.direction = (back ? -1 : 1) * leg / length;
      state.position = person_.path[i - 1] + leg * (s / length);
      break;
    }
    s -= length;
  }
  state.stride = person_.speed > 0 ? 0.25 * std::sin(2 * M_PI * walked / 1.4) : 0;
  return state;
}

double distance_to_person(const Person& person, const PersonState& state, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                          double& cosine) {
  const Ray ray{origin, direction};
  const double h = person.height;
  const Eigen::Vector2d side(-state.direction.y(), state.direction.x());
  double nearest = none;
  const auto take = [&](double distance, double cosine_there) {
    if (distance < nearest) {
      nearest = distance;
      cosine = cosine_there;
    }
  };
  double c = 0;
  double distance = cylinder(ray, state.position, 0.2, person.z + 0.48 * h, person.z + 0.84 * h, c);
  take(distance, c);
  for (const double leg : {-1.0, 1.0}) {
    distance = cylinder(ray, state.position + leg * (0.1 * side + 0.7 * state.stride * state.direction), 0.075, person.z, person.z + 0.5 * h, c);
    take(distance, c);
  }
  distance = ball(ray, Eigen::Vector3d(state.position.x(), state.position.y(), person.z + 0.92 * h), 0.11, c);
  take(distance, c);
  return nearest;
}

}  // namespace sgraph::sim
