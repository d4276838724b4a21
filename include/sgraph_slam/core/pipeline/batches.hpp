#pragma once

#include <exception>
#include <functional>
#include <optional>
#include <vector>

#include "sgraph_slam/core/pipeline/source.hpp"

namespace sgraph {

/// Gives the next event of a recording, or nothing at its end; may throw where it is damaged.
using NextEvent = std::function<std::optional<SensorEvent>()>;

/// A scan and what other sensors said before it.
struct SensorBatch {
  std::vector<SensorEvent> readings;  ///< no scans
  CloudPtr scan;                      ///< null: readings at the end of the recording
};

/// Reads events scan by scan. What reading throws ends the recording: it is kept, for whoever has worked on what came before.
class BatchReader {
 public:
  explicit BatchReader(NextEvent next) : next_(std::move(next)) {}

  /// Nothing when there is no more.
  std::optional<SensorBatch> next();
  /// Throws what reading has thrown, if it has.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  NextEvent next_;
  bool ended_ = false;
  std::exception_ptr error_;
};

/// Reads the recording while what was read before is being worked on, in order, on TBB's threads: as many as are allowed, at best two. Throws what
/// either throws; what reading throws comes after all that was read has been worked on.
void read_ahead(NextEvent next, const std::function<void(const SensorBatch&)>& work);

}  // namespace sgraph
