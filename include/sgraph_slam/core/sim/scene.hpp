#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

enum class SurfaceKind { wall, floor, ceiling, column, furniture, glass, ground, stairs };

const char* to_string(SurfaceKind value);

/// A flat piece of the building's surface.
struct Surface {
  std::vector<Eigen::Vector3d> outline;  ///< simple polygon, world frame [m]
  SurfaceKind kind = SurfaceKind::wall;
  Material material = Material::plaster;
  int object = 0;  ///< pieces of one wall, piece of furniture, ... share a number
};

/// Everything that stands still in a world, as polygons. Surfaces hidden inside of others (where walls meet) are left in: no ray sees them.
std::vector<Surface> surfaces_of(const World& world);

/// z of the ground around the building [m].
double ground_height(const World& world);

constexpr int packet_size = 16;

/// Rays traced together; unit directions.
struct RayPacket {
  std::array<Eigen::Vector3d, packet_size> origin;
  std::array<Eigen::Vector3d, packet_size> direction;
  std::array<double, packet_size> begin{};  ///< hits nearer than this are passed [m]
  std::array<bool, packet_size> active{};
};

/// What they hit.
struct HitPacket {
  std::array<double, packet_size> distance{};         ///< [m]; infinity: nothing
  std::array<double, packet_size> cosine{};           ///< of the angle of incidence, 0..1
  std::array<Eigen::Vector3d, packet_size> normal{};  ///< of the surface, to either side; unit length
  std::array<const Surface*, packet_size> surface{};
};

/// Ray caster over surfaces (Embree). `cast` may be called from several threads.
class Scene {
 public:
  explicit Scene(std::vector<Surface> surfaces);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  [[nodiscard]] HitPacket cast(const RayPacket& rays) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sgraph::sim
