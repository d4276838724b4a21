#pragma once

namespace sgraph {

/// To be called first in a program that runs for hours: memory that has been freed goes back to the system. glibc otherwise gives threads arenas of
/// their own, each of which keeps what its threads have freed, and once a large buffer has been freed it takes buffers of up to 32 MiB from the heap,
/// where they leave holes.
void return_freed_memory();

/// What the process has used so far; for reports.
double cpu_seconds();         ///< of all its threads, user and system
double thread_cpu_seconds();  ///< of the calling thread
double peak_memory_mib();     ///< largest resident size [MiB]

}  // namespace sgraph
