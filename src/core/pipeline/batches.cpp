#include "sgraph_slam/core/pipeline/batches.hpp"

#include <tbb/parallel_pipeline.h>

namespace sgraph {

std::optional<SensorBatch> BatchReader::next() {
  if (ended_) return std::nullopt;
  SensorBatch batch;
  try {
    while (auto event = next_()) {
      if (auto* scan = std::get_if<CloudPtr>(&*event)) {
        batch.scan = std::move(*scan);
        return batch;
      }
      batch.readings.push_back(*std::move(event));
    }
  } catch (...) {
    error_ = std::current_exception();
  }
  ended_ = true;
  return batch.readings.empty() ? std::nullopt : std::optional(std::move(batch));
}

void read_ahead(NextEvent next, const std::function<void(const SensorBatch&)>& work) {
  constexpr std::size_t in_flight = 4;
  BatchReader reader(std::move(next));
  const auto read = [&reader](tbb::flow_control& control) {
    auto batch = reader.next();
    if (!batch) control.stop();
    return batch;
  };
  using Batch = std::optional<SensorBatch>;
  tbb::parallel_pipeline(in_flight,
                         tbb::make_filter<void, Batch>(tbb::filter_mode::serial_in_order, read) &
                             tbb::make_filter<Batch, void>(tbb::filter_mode::serial_in_order, [&work](const Batch& batch) { work(*batch); }));
  reader.rethrow();
}

}  // namespace sgraph
