#pragma once

namespace sgraph {

/// What the process has used so far; for reports.
double cpu_seconds();         ///< of all its threads, user and system
double thread_cpu_seconds();  ///< of the calling thread
double peak_memory_mib();     ///< largest resident size [MiB]

}  // namespace sgraph
