#pragma once

#include "sgraph_slam/core/sensor/ring_table.hpp"
#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// Whether the points lie on the sensor's cones as they do when nobody has moved them since.
[[nodiscard]] bool lies_on_cones(const RingTable& table, const Cloud& cloud);

/// Whether most points are at the elevation of a beam; with `by_field`, of the one whose number they bear. A cloud that is all but empty passes.
[[nodiscard]] bool lies_on_beams(const RingTable& table, bool by_field, const Cloud& cloud);

}  // namespace sgraph
