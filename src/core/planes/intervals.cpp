#include "sgraph_slam/core/planes/intervals.hpp"

#include <algorithm>
#include <utility>

namespace sgraph {

Intervals unite(Intervals parts, double gap) {
  parts.erase(std::remove_if(parts.begin(), parts.end(), [](const Interval& i) { return !(i.high > i.low); }), parts.end());
  std::sort(parts.begin(), parts.end(), [](const Interval& a, const Interval& b) { return a.low < b.low || (a.low == b.low && a.high < b.high); });
  Intervals united;
  for (const Interval& part : parts) {
    if (!united.empty() && part.low <= united.back().high + gap) {
      united.back().high = std::max(united.back().high, part.high);
    } else {
      united.push_back(part);
    }
  }
  return united;
}

Intervals covered(const Intervals& parts, int times) {
  std::vector<std::pair<double, int>> steps;  // where a part begins (+1) or ends (-1); at the same place beginnings first
  for (const Interval& part : parts) {
    if (!(part.high > part.low)) continue;
    steps.emplace_back(part.low, -1);
    steps.emplace_back(part.high, 1);
  }
  std::sort(steps.begin(), steps.end());
  Intervals stretches;
  int depth = 0;
  for (const auto& [at, end] : steps) {
    const int before = depth;
    depth -= end;
    if (before < times && depth >= times) stretches.push_back({at, at});
    if (before >= times && depth < times) stretches.back().high = at;
  }
  return unite(std::move(stretches));
}

Interval hull(const Intervals& parts) {
  if (parts.empty()) return {};
  return {parts.front().low, parts.back().high};
}

Intervals clip(const Intervals& parts, Interval within) {
  Intervals inside;
  for (const Interval& part : parts) {
    const Interval common{std::max(part.low, within.low), std::min(part.high, within.high)};
    if (common.high > common.low) inside.push_back(common);
  }
  return inside;
}

Intervals gaps(const Intervals& parts, Interval within, double shortest) {
  Intervals open;
  double reached = within.low;
  for (const Interval& part : clip(parts, within)) {
    if (part.low - reached > shortest) open.push_back({reached, part.low});
    reached = std::max(reached, part.high);
  }
  if (within.high - reached > shortest) open.push_back({reached, within.high});
  return open;
}

double total_length(const Intervals& parts) {
  double sum = 0;
  for (const Interval& part : parts) sum += part.length();
  return sum;
}

double overlap(Interval a, Interval b) { return std::min(a.high, b.high) - std::max(a.low, b.low); }

}  // namespace sgraph
