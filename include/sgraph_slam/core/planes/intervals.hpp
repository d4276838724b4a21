#pragma once

#include <vector>

namespace sgraph {

/// A stretch of a line [m].
struct Interval {
  double low = 0;
  double high = 0;

  [[nodiscard]] double length() const { return high - low; }
  [[nodiscard]] double center() const { return 0.5 * (low + high); }
};

/// Disjoint stretches in ascending order.
using Intervals = std::vector<Interval>;

/// The union as disjoint stretches in order; those less than `gap` apart become one. Empty and reversed ones are dropped.
Intervals unite(Intervals parts, double gap = 0);

/// What lies in at least `times` of the parts, in order; all of them for `times` 1.
Intervals covered(const Intervals& parts, int times);

/// From the first beginning to the last end; {0, 0} when there is none.
Interval hull(const Intervals& parts);

/// The parts within a stretch.
Intervals clip(const Intervals& parts, Interval within);

/// What a stretch has that the parts do not cover, longer than `shortest`.
Intervals gaps(const Intervals& parts, Interval within, double shortest = 0);

/// Sum of the lengths.
double total_length(const Intervals& parts);

/// Length of the common stretch; negative: the distance between the two.
double overlap(Interval a, Interval b);

}  // namespace sgraph
