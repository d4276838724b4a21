#pragma once

#include <tbb/parallel_pipeline.h>

#include "sgraph_slam/core/pipeline/batches.hpp"

namespace sgraph {

/// The first filter of a pipeline over a recording: one batch after the other, in order. The reader must outlive the pipeline.
inline tbb::filter<void, std::optional<SensorBatch>> reading(BatchReader& reader) {
  return tbb::make_filter<void, std::optional<SensorBatch>>(tbb::filter_mode::serial_in_order, [&reader](tbb::flow_control& control) {
    auto batch = reader.next();
    if (!batch) control.stop();
    return batch;
  });
}

}  // namespace sgraph
