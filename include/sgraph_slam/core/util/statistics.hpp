#pragma once

#include <vector>

namespace sgraph {

/// Figures of a set of errors, in the errors' unit (sse: its square). All 0 for an empty set.
struct Statistics {
  int count = 0;
  double rmse = 0;
  double mean = 0;
  double median = 0;
  double std = 0;  ///< of the population (divided by count)
  double min = 0;
  double max = 0;
  double sse = 0;  ///< sum of squared errors
};

Statistics statistics_of(std::vector<double> errors);

/// The value below which the share `fraction` (0..1) of a set lies, linear between neighbours. 0 for an empty set.
double quantile(std::vector<double> values, double fraction);

/// A member of the set that as many lie below as above, the upper one of two: the median of a large set, without sorting it. 0 for an empty set.
double upper_median(std::vector<double> values);

}  // namespace sgraph
