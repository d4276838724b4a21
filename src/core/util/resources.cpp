#include "sgraph_slam/core/util/resources.hpp"

#include <sys/resource.h>

namespace sgraph {
namespace {

rusage used() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return usage;
}

double seconds(const timeval& time) { return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec); }

}  // namespace

double cpu_seconds() {
  const rusage usage = used();
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_memory_mib() { return static_cast<double>(used().ru_maxrss) / 1024; }  // Linux counts KiB

}  // namespace sgraph
