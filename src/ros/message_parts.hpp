#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <geometry_msgs/Point.h>
#include <geometry_msgs/Twist.h>
#include <geometry_msgs/Vector3.h>
#include <boost/array.hpp>

#include "sgraph_slam/core/types/pose.hpp"

/// The pieces of which messages.cpp and graph_message.cpp put messages together.
namespace sgraph {

/// How far the length of what should be a unit may be from 1: a message may have been through text or single precision.
inline constexpr double unit_tolerance = 1e-4;

inline geometry_msgs::Point to_point(const Eigen::Vector3d& v) {
  geometry_msgs::Point message;
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
  return message;
}

inline geometry_msgs::Vector3 to_vector(const Eigen::Vector3d& v) {
  geometry_msgs::Vector3 message;
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
  return message;
}

/// Of a Point or a Vector3.
template <class Message>
Eigen::Vector3d vector_of(const Message& message) {
  return {message.x, message.y, message.z};
}

inline std::vector<geometry_msgs::Point> to_points(const std::vector<Eigen::Vector3d>& points) {
  std::vector<geometry_msgs::Point> messages(points.size());
  std::transform(points.begin(), points.end(), messages.begin(), to_point);
  return messages;
}

inline std::vector<Eigen::Vector3d> points_of(const std::vector<geometry_msgs::Point>& messages) {
  std::vector<Eigen::Vector3d> points(messages.size());
  std::transform(messages.begin(), messages.end(), points.begin(), vector_of<geometry_msgs::Point>);
  return points;
}

inline bool finite(const std::vector<Eigen::Vector3d>& points) {
  return std::all_of(points.begin(), points.end(), [](const Eigen::Vector3d& p) { return p.allFinite(); });
}

template <int N>
void to_rows(const Eigen::Matrix<double, N, N>& matrix, boost::array<double, static_cast<std::size_t>(N* N)>& rows) {
  Eigen::Map<Eigen::Matrix<double, N, N, Eigen::RowMajor>>(rows.data()) = matrix;
}

template <int N>
Eigen::Matrix<double, N, N> from_rows(const boost::array<double, static_cast<std::size_t>(N* N)>& rows) {
  return Eigen::Map<const Eigen::Matrix<double, N, N, Eigen::RowMajor>>(rows.data());
}

inline std::vector<geometry_msgs::Twist> to_twists(const std::vector<Vector6>& directions) {
  std::vector<geometry_msgs::Twist> messages(directions.size());
  for (std::size_t i = 0; i < directions.size(); ++i) {
    messages[i].angular = to_vector(directions[i].head<3>());
    messages[i].linear = to_vector(directions[i].tail<3>());
  }
  return messages;
}

inline std::vector<Vector6> directions_of(const std::vector<geometry_msgs::Twist>& messages) {
  std::vector<Vector6> directions(messages.size());
  for (std::size_t i = 0; i < messages.size(); ++i) directions[i] << vector_of(messages[i].angular), vector_of(messages[i].linear);
  return directions;
}

inline bool finite(const std::vector<Vector6>& directions) {
  return std::all_of(directions.begin(), directions.end(), [](const Vector6& v) { return v.allFinite(); });
}

inline bool is_unit(const Eigen::Vector3d& normal) { return std::abs(normal.norm() - 1) < unit_tolerance; }

}  // namespace sgraph
