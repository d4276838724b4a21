#include "min_cut.hpp"

#include <algorithm>
#include <deque>
#include <limits>

namespace sgraph {
namespace {

constexpr double nothing = 1e-9;  // a capacity this small is used up

}  // namespace

bool MinCut::find_levels() {
  level_.assign(edges_of_.size(), -1);
  level_[source_] = 0;
  std::deque<std::size_t> queue{source_};
  while (!queue.empty()) {
    const std::size_t node = queue.front();
    queue.pop_front();
    for (const std::size_t e : edges_of_[node]) {
      const Edge& edge = edges_[e];
      if (edge.capacity <= nothing || level_[edge.to] >= 0) continue;
      level_[edge.to] = level_[node] + 1;
      queue.push_back(edge.to);
    }
  }
  return level_[sink_] >= 0;
}

double MinCut::push(std::size_t node, double most) {
  if (node == sink_) return most;
  for (std::size_t& k = next_[node]; k < edges_of_[node].size(); ++k) {
    const std::size_t e = edges_of_[node][k];
    const Edge edge = edges_[e];
    if (edge.capacity <= nothing || level_[edge.to] != level_[node] + 1) continue;
    const double pushed = push(edge.to, std::min(most, edge.capacity));
    if (pushed <= nothing) continue;
    edges_[e].capacity -= pushed;
    edges_[e ^ 1].capacity += pushed;
    return pushed;
  }
  return 0;
}

std::vector<char> MinCut::solve() {
  while (find_levels()) {
    next_.assign(edges_of_.size(), 0);
    while (push(source_, std::numeric_limits<double>::infinity()) > nothing) {
    }
  }
  std::vector<char> on_source_side(edges_of_.size() - 2);
  for (std::size_t i = 0; i < on_source_side.size(); ++i) on_source_side[i] = level_[i] >= 0;
  return on_source_side;
}

}  // namespace sgraph
