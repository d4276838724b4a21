#include "sgraph_slam/core/places/topology.hpp"

#include <algorithm>

namespace sgraph {
namespace {

const Place* place_of(const std::vector<Place>& places, const Eigen::Vector2d& position) {
  const auto found = std::find_if(places.begin(), places.end(), [&](const Place& place) { return contains(place.outline, position); });
  return found == places.end() ? nullptr : &*found;
}

struct Crossings {
  SceneOpening opening;
  int count = 0;
};

void note(std::vector<Crossings>& all, const Place& a, const Place& b, const Eigen::Vector3d& position, double same) {
  const std::string& from = std::min(a.name, b.name);
  const std::string& to = std::max(a.name, b.name);
  for (Crossings& known : all) {
    if (known.opening.from != from || known.opening.to != to || (known.opening.position - position).head<2>().norm() > same) continue;
    known.opening.position = (known.opening.position * known.count + position) / (known.count + 1);
    ++known.count;
    return;
  }
  all.push_back({{from, to, position}, 1});
}

}  // namespace

std::vector<SceneOpening> find_openings(const std::vector<Place>& places, const std::vector<Eigen::Vector3d>& path, double max_way, double same) {
  std::vector<Crossings> all;
  const Place* last = nullptr;
  Eigen::Vector3d left = Eigen::Vector3d::Zero();  // last position inside `last`
  double way = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i > 0) way += (path[i] - path[i - 1]).norm();
    const Place* here = place_of(places, path[i].head<2>());
    if (!here) continue;
    if (last && here != last && way <= max_way) note(all, *last, *here, 0.5 * (left + path[i]), same);
    last = here;
    left = path[i];
    way = 0;
  }
  std::vector<SceneOpening> openings;
  for (Crossings& one : all) openings.push_back(std::move(one.opening));
  return openings;
}

}  // namespace sgraph
