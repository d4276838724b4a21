#pragma once

#include <array>
#include <string>
#include <variant>

#include "sgraph_slam/core/graph/factors/aligned_walls.hpp"
#include "sgraph_slam/core/graph/factors/corridor_plane.hpp"
#include "sgraph_slam/core/graph/factors/corridor_width.hpp"
#include "sgraph_slam/core/graph/factors/parallel_planes.hpp"
#include "sgraph_slam/core/graph/factors/perpendicular_planes.hpp"
#include "sgraph_slam/core/graph/factors/plane_prior.hpp"
#include "sgraph_slam/core/graph/factors/pose_plane.hpp"
#include "sgraph_slam/core/graph/factors/pose_plane_points.hpp"
#include "sgraph_slam/core/graph/factors/room_plane.hpp"
#include "sgraph_slam/core/graph/factors/room_width.hpp"
#include "sgraph_slam/core/graph/factors/se3_between.hpp"
#include "sgraph_slam/core/graph/factors/wall_thickness.hpp"
#include "sgraph_slam/core/graph/robust_loss.hpp"
#include "sgraph_slam/core/graph/variables.hpp"

namespace sgraph {

/// The one list of factors. Each tells about itself in its own header: `type` (its name in files), `residuals` and `rank` (how many of them are
/// independent), and `describe`, which shows a visitor its variables (`block`, `blocks`), its numbers (`field`, `sigma`: positive, `choice`, `index`:
/// below a limit) and the keys they have in JSON. What can be derived from that is: the functions below, JSON, equality.
using FactorData = std::variant<Se3Between, PosePlane, PosePlanePoints, PlanePrior, ParallelPlanes, PerpendicularPlanes, WallThickness, RoomPlane,
                                CorridorPlane, RoomWidth, CorridorWidth, AlignedWalls>;

/// One term of the cost: `1/2 loss(|e|^2)` with the weighted residual `e` of the data. A plain value; its id is its key in the graph.
struct Factor {
  FactorData data;
  RobustLoss loss;
};

/// One or two variables, held in place.
class BlockIds {
 public:
  BlockIds() : size_(0) {}
  BlockIds(const VariableId& a) : ids_{a, {}}, size_(1) {}
  BlockIds(const VariableId& a, const VariableId& b) : ids_{a, b}, size_(2) {}

  void push_back(const VariableId& id) { ids_[size_++] = id; }
  [[nodiscard]] std::size_t size() const { return size_; }
  const VariableId& operator[](std::size_t i) const { return ids_[i]; }
  [[nodiscard]] const VariableId* begin() const { return ids_.data(); }
  [[nodiscard]] const VariableId* end() const { return ids_.data() + size_; }

 private:
  std::array<VariableId, 2> ids_;
  std::size_t size_;
};

/// Variables of the factor in the order of its cost's parameter blocks.
BlockIds blocks(const FactorData& data);

/// Its name in files; of a relative pose by where it comes from.
const char* type_name(const FactorData& data);

/// A plane observed from a keyframe, in whichever form.
inline bool is_view(const FactorData& data) { return std::holds_alternative<PosePlane>(data) || std::holds_alternative<PosePlanePoints>(data); }

/// Number of residuals, and how many of them are independent (the degrees of freedom of its chi-square).
int residual_size(const FactorData& data);
int residual_rank(const FactorData& data);

/// All numbers finite, weights and sigmas positive, sides and axes in range.
bool valid(const Factor& factor);

/// The factor with plane `from` replaced by `to` wherever it occurs.
FactorData repointed(FactorData data, PlaneId from, PlaneId to);

bool operator==(const Factor& a, const Factor& b);

}  // namespace sgraph
