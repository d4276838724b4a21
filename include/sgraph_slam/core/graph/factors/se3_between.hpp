#pragma once

#include <array>

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/graph/sqrt_information.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// Relative pose of two keyframes: from odometry, from a loop closure (then with a robust loss), or of a keyframe that has been retired.
///
///   e = W Log( Z^-1 T_map_from^-1 T_map_to ),  6 residuals: rotation [rad], translation [m], in the frame of `to`
///
/// Blocks: keyframe `from`, keyframe `to`. Degenerate (jump of the logarithm) at a rotation error of pi.
/// Source: paper, Robot Tracking Layer; design: keyframe-to-keyframe factor.
struct Se3Between {
  enum class Source {
    odometry,
    loop,
    ride,     ///< odometry in a lift: nothing but an accelerometer tells the height
    retired,  ///< `to` says nothing more about the map and is kept where it stood beside `from`
  };
  static constexpr std::array<const char*, 4> source_types{"se3_between", "loop", "ride", "retired"};  ///< in files

  KeyframeId from;
  KeyframeId to;
  Pose T_from_to;             ///< measurement Z
  SqrtInformation<6> weight;  ///< covariance order rotation, translation; right perturbation of Z
  Source source = Source::odometry;

  static constexpr const char* type = "se3_between";
  static constexpr int residuals = 6;
  static constexpr int rank = 6;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.block("from", f.from);
    v.block("to", f.to);
    v.field("pose", f.T_from_to);
    v.field("sqrt_information", f.weight);
    v.type(f.source, source_types);
  }
};

CostPtr make_cost(const Se3Between& factor);

}  // namespace sgraph
