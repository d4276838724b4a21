#include "sgraph_slam/core/util/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph {
namespace {

double quantile_of_sorted(const std::vector<double>& sorted, double fraction) {
  const double position = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(position);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (position - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

}  // namespace

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return quantile_of_sorted(values, fraction);
}

Statistics statistics_of(std::vector<double> errors) {
  if (errors.empty()) return {};
  std::sort(errors.begin(), errors.end());
  const auto n = static_cast<double>(errors.size());
  Statistics s;
  s.count = static_cast<int>(errors.size());
  double sum = 0;
  for (const double e : errors) sum += e, s.sse += e * e;
  s.mean = sum / n;
  s.rmse = std::sqrt(s.sse / n);
  double deviations = 0;
  for (const double e : errors) deviations += (e - s.mean) * (e - s.mean);
  s.std = std::sqrt(deviations / n);
  s.median = quantile_of_sorted(errors, 0.5);
  s.min = errors.front();
  s.max = errors.back();
  return s;
}

double upper_median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace sgraph
