#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// Values of the graph as JSON, exact (doubles are printed so that they read back as the same numbers).
template <int N>
nlohmann::json vector_json(const Eigen::Matrix<double, N, 1>& v) {
  nlohmann::json out = nlohmann::json::array();
  for (int i = 0; i < N; ++i) out.push_back(v[i]);
  return out;
}

/// Throws std::runtime_error when it isn't an array of N numbers.
template <int N>
Eigen::Matrix<double, N, 1> vector_from(const nlohmann::json& json) {
  if (!json.is_array() || json.size() != static_cast<std::size_t>(N)) throw std::runtime_error("expected " + std::to_string(N) + " numbers");
  Eigen::Matrix<double, N, 1> v;
  for (int i = 0; i < N; ++i) v[i] = json[static_cast<std::size_t>(i)].get<double>();
  return v;
}

nlohmann::json pose_json(const Pose& pose);  ///< [x y z qx qy qz qw]
Pose pose_from(const nlohmann::json& json);
nlohmann::json plane_json(const Plane& plane);  ///< [nx ny nz d]
Plane plane_from(const nlohmann::json& json);

nlohmann::json factor_json(FactorId id, const Factor& factor);
Factor factor_from(const nlohmann::json& json);

}  // namespace sgraph
