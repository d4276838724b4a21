#include "sgraph_slam/core/pipeline/pipeline.hpp"

#include "reading_filter.hpp"

namespace sgraph {
namespace {

// Scans between reading and mapping. Few, for their clouds are held; enough that a global solve doesn't stop the odometry.
constexpr std::size_t in_flight = 16;

}  // namespace

void Pipeline::process_all(NextEvent next, const std::function<void(const ScanRecord&)>& done) {
  BatchReader reader(std::move(next));
  const auto measure = [this](const std::optional<SensorBatch>& batch) -> std::optional<MeasuredScan> {
    for (const SensorEvent& reading : batch->readings) {
      if (const auto* odometry = std::get_if<OdometrySample>(&reading)) add(*odometry);
      if (const auto* imu = std::get_if<ImuSample>(&reading)) add(*imu);
    }
    if (!batch->scan) return std::nullopt;
    return front_end_.process(*batch->scan);
  };
  const auto find_planes = [this](std::optional<MeasuredScan> scan) {
    if (scan) scan = segmented(*std::move(scan));
    return scan;
  };
  const auto map = [this, &done](const std::optional<MeasuredScan>& scan) {
    if (scan) done(run_.take(*scan));
  };
  using Batch = std::optional<SensorBatch>;
  using Measured = std::optional<MeasuredScan>;
  constexpr auto in_order = tbb::filter_mode::serial_in_order;
  tbb::parallel_pipeline(in_flight, reading(reader) & tbb::make_filter<Batch, Measured>(in_order, measure) &
                                        tbb::make_filter<Measured, Measured>(tbb::filter_mode::parallel, find_planes) &
                                        tbb::make_filter<Measured, void>(in_order, map));
  reader.rethrow();
}

}  // namespace sgraph
