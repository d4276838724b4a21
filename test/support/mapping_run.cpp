#include "mapping_run.hpp"

#include <cmath>
#include <cstdlib>
#include <iostream>

#include <Eigen/Dense>

namespace sgraph {

// Four rooms on both sides of a corridor, 15 cm walls, open doors.
MappedBuilding office() {
  MappedBuilding building;
  building.add_room(0, 5.8, 18.85, 7.85, {{{4.0, 5.0}, {13.0, 14.0}}, {}, {{3.85, 4.85}, {13.85, 14.85}}, {}});
  building.add_room(0, 0, 9.05, 5.65, {{}, {}, {{4.05, 5.05}}, {}});
  building.add_room(9.2, 0, 18.85, 5.65, {{}, {}, {{4.85, 5.85}}, {}});
  building.add_room(0, 8.0, 7.85, 13.85, {{{4.0, 5.0}}, {}, {}, {}});
  building.add_room(8.0, 8.0, 18.85, 13.85, {{{6.0, 7.0}}, {}, {}, {}});
  return building;
}

std::vector<Eigen::Vector2d> office_walk() {
  return {{2, 2},     {7, 2},   {7, 4},   {4.5, 4.5}, {4.5, 6.8},  {13.5, 6.8}, {13.5, 4}, {17, 3}, {11, 2}, {13.5, 4}, {13.5, 6.8}, {14.5, 6.8},
          {14.5, 10}, {17, 12}, {10, 12}, {14.5, 9},  {14.5, 6.8}, {4.5, 6.8},  {4.5, 10}, {2, 12}, {6, 12}, {4.5, 9},  {4.5, 4},    {2, 2}};
}

namespace {

double position_rms(const std::vector<Eigen::Vector3d>& estimate, const std::vector<Eigen::Vector3d>& truth) {
  Eigen::Matrix3Xd a(3, static_cast<Eigen::Index>(truth.size()));
  Eigen::Matrix3Xd b(3, a.cols());
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    a.col(i) = estimate[static_cast<std::size_t>(i)];
    b.col(i) = truth[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  return std::sqrt(((T.topLeftCorner<3, 3>() * a).colwise() + Eigen::Vector3d(T.topRightCorner<3, 1>()) - b).colwise().squaredNorm().mean());
}

}  // namespace

Outcome map_walk(const std::vector<SeenKeyframe>& walk, const MappingParams& params) {
  BackEnd back_end(params, MappedBuilding::T_base_lidar());
  for (const SeenKeyframe& seen : walk) back_end.process(seen.keyframe, seen.segments);
  Outcome result;
  result.snapshot = back_end.optimize();
  std::vector<Eigen::Vector3d> estimate;
  std::vector<Eigen::Vector3d> odometry;
  std::vector<Eigen::Vector3d> truth;
  for (const SeenKeyframe& seen : walk) {
    estimate.push_back(result.snapshot->keyframes.at(seen.keyframe.id).T_map_base.translation);
    odometry.push_back(seen.keyframe.T_odom_base.translation);
    truth.push_back(seen.T_world_base.translation);
  }
  result.decisions = back_end.decisions();
  result.ate = position_rms(estimate, truth);
  result.odometry_ate = position_rms(odometry, truth);
  if (std::getenv("SGRAPH_SHOW")) {
    for (const Decision& d : back_end.decisions())
      std::cout << d.keyframe.value << (d.accepted ? " + " : " - ") << d.what << ": " << d.reason << "\n";
    for (const auto& [id, p] : result.snapshot->planes)
      std::cout << "plane " << id.value << " " << to_string(p.plane_class) << " n " << p.plane.normal.transpose() << " d " << p.plane.d << " views "
                << p.keyframes.size() << "\n";
    for (const auto& [id, room] : result.snapshot->rooms)
      std::cout << "room " << id.value << " " << room.center.transpose() << "  " << room.width.transpose() << "\n";
    for (const auto& [id, c] : result.snapshot->corridors)
      std::cout << "corridor " << id.value << " " << c.center.transpose() << "  " << c.width << " " << c.length << "\n";
    for (const auto& o : result.snapshot->openings) std::cout << o.from << " " << o.to << " " << o.position.transpose() << "\n";
    std::cout << "ate " << result.ate << " odometry " << result.odometry_ate << "\n";
  }
  return result;
}

}  // namespace sgraph
