#include "sgraph_slam/core/storeys/find_storeys.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

constexpr double level_band = 0.08;   // [m] that a level path strays from its mean over the last `level_way`: gait, thresholds, the odometry's error
constexpr double level_way = 3.0;     // [m]
constexpr double shortest_run = 1.5;  // [m] of a level run; a step's tread is no floor
constexpr double headroom = 2.2;      // [m] between two floors on whose lower one a person can stand, slab included
constexpr double same_floor = 0.5;    // [m] that the height of a storey may be off when it is entered again: drift over many flights
constexpr double widest_landing = 4;  // [m] of the path on it: two flights of 1.5 m beside each other and the way round
constexpr double edge = 0.1;          // [m] that a path is above or below a floor when it has left it
constexpr double left = 0.3;          // [m] after which it is sure that it has: two steps

struct Run {
  std::size_t begin, end;  // positions
  double height;           // mean [m]
  double way;              // [m]
  double extent;           // diagonal of the box around it, on the ground [m]
  int storey = stairwell;
  const LiftRide* ride = nullptr;  // with which it begins
};

std::vector<double> ways(const std::vector<Eigen::Vector3d>& positions) {
  std::vector<double> way(positions.size(), 0.0);
  for (std::size_t i = 1; i < positions.size(); ++i) way[i] = way[i - 1] + (positions[i] - positions[i - 1]).norm();
  return way;
}

Run run_of(const std::vector<Eigen::Vector3d>& positions, const std::vector<double>& way, std::size_t begin, std::size_t end) {
  Run run{begin, end, 0, way[end - 1] - way[begin], 0, stairwell, nullptr};
  Eigen::AlignedBox2d box;
  for (std::size_t i = begin; i < end; ++i) {
    run.height += positions[i].z() / static_cast<double>(end - begin);
    box.extend(Eigen::Vector2d(positions[i].head<2>()));
  }
  run.extent = box.diagonal().norm();
  return run;
}

const LiftRide* ride_to(const std::vector<LiftRide>& rides, std::size_t position) {
  const auto found = std::find_if(rides.begin(), rides.end(), [position](const LiftRide& ride) { return ride.position == position; });
  return found == rides.end() ? nullptr : &*found;
}

// The stretches on which the path stays level; what is shorter than a run is part of a climb, but where it was walked after a ride.
std::vector<Run> level_runs(const std::vector<Eigen::Vector3d>& positions, const std::vector<double>& way, const std::vector<LiftRide>& rides) {
  std::vector<Run> runs;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= positions.size(); ++i) {
    if (i < positions.size() && ride_to(rides, i) == nullptr) {
      double mean = 0;
      double count = 0;
      for (std::size_t k = i; k-- > begin && way[i - 1] - way[k] <= level_way;) {
        mean += positions[k].z();
        ++count;
      }
      if (std::abs(positions[i].z() - mean / count) <= level_band) continue;
    }
    Run run = run_of(positions, way, begin, i);
    run.ride = ride_to(rides, begin);
    if (begin == 0 || run.ride != nullptr || run.way >= shortest_run) runs.push_back(run);
    begin = i;
  }
  return runs;
}

// Length of the path on the ground between two runs.
double ground_between(const std::vector<Eigen::Vector3d>& positions, const Run& from, const Run& to) {
  double length = 0;
  for (std::size_t i = from.end; i <= to.begin; ++i) length += (positions[i] - positions[i - 1]).head<2>().norm();
  return length;
}

// Of the storeys in a group that has one.
int nearest(const StoreysOfPath& known, int group, double height) {
  int best = -1;
  for (std::size_t s = 0; s < known.heights.size(); ++s) {
    if (known.group[s] != group) continue;
    if (best < 0 || std::abs(known.heights[s] - height) < std::abs(known.heights[static_cast<std::size_t>(best)] - height))
      best = static_cast<int>(s);
  }
  return best;
}

int new_storey(StoreysOfPath& known, int group, double height) {
  known.heights.push_back(height);
  known.group.push_back(group);
  return static_cast<int>(known.heights.size()) - 1;
}

// Which storey each run is on.
void name_runs(const std::vector<Eigen::Vector3d>& positions, std::vector<Run>& runs, StoreysOfPath& known) {
  int group = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    Run& run = runs[r];
    if (r == 0) {
      run.storey = new_storey(known, group, run.height);
      continue;
    }
    if (run.ride != nullptr) {
      const int seen = run.ride->storey.value_or(-1);
      const bool recognised = seen >= 0 && static_cast<std::size_t>(seen) < known.heights.size();
      group = recognised ? known.group[static_cast<std::size_t>(seen)] : *std::max_element(known.group.begin(), known.group.end()) + 1;
      run.storey = recognised ? seen : new_storey(known, group, run.height);
      continue;
    }
    const Run& before = runs[r - 1];
    const int near = nearest(known, group, run.height);
    const double off = std::abs(run.height - known.heights[static_cast<std::size_t>(near)]);
    const double risen = std::abs(run.height - before.height);
    if (off < same_floor) {
      run.storey = near;
    } else if (before.storey != stairwell && risen > same_floor && ground_between(positions, before, run) < 0.8 * risen) {
      run.storey = before.storey;
    } else if (run.extent >= widest_landing || (off >= headroom && r + 1 == runs.size())) {
      run.storey = near;
      if (off < headroom) continue;
      run.storey = new_storey(known, group, run.height);
    }
  }
}

}  // namespace

StoreysOfPath find_storeys(const std::vector<Eigen::Vector3d>& positions, const std::vector<LiftRide>& rides) {
  StoreysOfPath result;
  if (positions.empty()) return result;
  const std::vector<double> way = ways(positions);
  std::vector<Run> runs = level_runs(positions, way, rides);
  name_runs(positions, runs, result);
  result.storey.assign(positions.size(), stairwell);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const Run& run = runs[r];
    std::fill(result.storey.begin() + static_cast<std::ptrdiff_t>(run.begin), result.storey.begin() + static_cast<std::ptrdiff_t>(run.end),
              run.storey);
    const bool last = r + 1 == runs.size() || runs[r + 1].ride != nullptr;
    const std::size_t end = r + 1 == runs.size() ? positions.size() : runs[r + 1].begin;
    if (run.end == end) continue;
    // The climb after it.
    const auto off = [&](std::size_t i, const Run& of) { return std::abs(positions[i].z() - of.height); };
    double farthest = 0;
    for (std::size_t i = run.end; i < end; ++i) farthest = std::max(farthest, off(i, run));
    const bool within_a_storey = last ? farthest < left : run.storey == runs[r + 1].storey;
    std::size_t i = run.end;
    for (; i < end && (within_a_storey || off(i, run) < edge); ++i) result.storey[i] = run.storey;
    if (last) continue;
    for (std::size_t k = end; k > i && off(k - 1, runs[r + 1]) < edge; --k) result.storey[k - 1] = runs[r + 1].storey;
  }
  return result;
}

}  // namespace sgraph
