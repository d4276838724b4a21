#pragma once

#include <string>

namespace sgraph {

/// The text that tells how far a run over a recording has come: a bar that rewrites its line on a terminal, elsewhere a line every 10 %.
class Progress {
 public:
  /// `total`: scans in all.
  Progress(int total, bool terminal) : total_(total), terminal_(terminal) {}

  /// What to print after `done` scans that span `data_seconds` of the recording and took `wall_seconds`; empty when it is nothing new.
  std::string after(int done, double data_seconds, double wall_seconds);
  /// What to print at the end, so that the next output starts on its own line.
  [[nodiscard]] std::string end() const { return terminal_ && printed_ ? "\n" : ""; }

 private:
  int total_;
  bool terminal_;
  bool printed_ = false;
  int tenths_ = 0;            // printed so far, without a terminal
  double last_printed_ = -1;  // wall time of it, on a terminal
};

}  // namespace sgraph
