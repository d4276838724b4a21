#include "sgraph_slam/core/util/resources.hpp"

#include <malloc.h>
#include <sys/resource.h>

#include <ctime>

namespace sgraph {

namespace {

constexpr int arenas = 2;
constexpr int own_pages = 128 * 1024;  // [bytes] a buffer of this size has pages of its own: glibc's first choice, which is kept to

double seconds_of(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

void return_freed_memory() {
  mallopt(M_ARENA_MAX, arenas);
  mallopt(M_MMAP_THRESHOLD, own_pages);
  mallopt(M_TRIM_THRESHOLD, 2 * own_pages);
}

double cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }
double thread_cpu_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }

double peak_memory_mib() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts KiB
}

}  // namespace sgraph
