#include "sgraph_slam/core/util/progress.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace sgraph {

std::string Progress::after(int done, double data_seconds, double wall_seconds) {
  if (total_ <= 0) return "";
  const double share = std::min(1.0, static_cast<double>(done) / total_);
  if (terminal_) {
    constexpr double least_pause = 0.1;  // s
    if (done < total_ && last_printed_ >= 0 && wall_seconds - last_printed_ < least_pause) return "";
    last_printed_ = wall_seconds;
  } else {
    const int tenths = static_cast<int>(10 * share + 1e-9);
    if (tenths == tenths_) return "";
    tenths_ = tenths;
  }
  printed_ = true;
  const double speed = wall_seconds > 0 ? data_seconds / wall_seconds : 0;
  const double left = share > 0 ? wall_seconds * (1 - share) / share : 0;
  std::array<char, 160> figures{};
  std::snprintf(figures.data(), figures.size(), "%3.0f %%  %d/%d scans  %.1f x real time  %.0f s left", 100 * share, done, total_, speed, left);
  if (!terminal_) return std::string(figures.data()) + '\n';
  constexpr int cells = 30;
  std::string bar(static_cast<std::size_t>(cells * share), '=');
  bar.resize(cells, ' ');
  return "\r[" + bar + "] " + figures.data() + "\x1b[K";
}

}  // namespace sgraph
