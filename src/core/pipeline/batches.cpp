#include "sgraph_slam/core/pipeline/batches.hpp"

#include "reading_filter.hpp"

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
  using Batch = std::optional<SensorBatch>;
  tbb::parallel_pipeline(
      in_flight, reading(reader) & tbb::make_filter<Batch, void>(tbb::filter_mode::serial_in_order, [&work](const Batch& batch) { work(*batch); }));
  reader.rethrow();
}

}  // namespace sgraph
