#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/pose.hpp"

/// Simulated buildings, LiDAR and robot (docs/worlds.md).
namespace sgraph::sim {

/// What is wrong with a world, with the file and line where there is one.
class WorldError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class Material { plaster, concrete, wood, fabric, metal, glass, ground };

/// A hole in a wall: door, passage, or window when it holds a pane.
struct Opening {
  double begin = 0;     ///< along the wall from `Wall::p` [m]
  double end = 0;       ///< [m]
  double bottom = 0;    ///< above the storey's floor [m]
  double top = 2.1;     ///< [m]
  bool pane = false;    ///< filled with glass
  bool closed = false;  ///< a door that stands shut: its leaf is a block named "door"
  bool joins = false;   ///< so wide that what lies on its two sides is one place
};

/// A straight wall along its centre line from p to q.
struct Wall {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Eigen::Vector2d q = Eigen::Vector2d::Zero();
  double thickness = 0.15;
  double bottom = 0;  ///< world z [m]
  double height = 2.8;
  double extend_p = 0;  ///< the body goes this far beyond p (or q), so that the corners of a polyline are closed [m]
  double extend_q = 0;  ///< [m]
  bool glass = false;   ///< a glass partition: one pane along the centre line
  Material material = Material::plaster;
  std::vector<Opening> openings;  ///< in order, not overlapping
  double lean = 0;                ///< how far the body moves to the left of p -> q with each metre of height; 0 at half height
  double bow = 0;                 ///< how far its middle stands to the left of the line from p to q, as a parabola [m]
  int line = 0;                   ///< in the world's file

  [[nodiscard]] double length() const { return (q - p).norm(); }
  [[nodiscard]] Eigen::Vector2d direction() const { return (q - p).normalized(); }
};

/// An upright box or, with `round`, a cylinder of diameter size.x.
struct Block {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< along the box's own axes [m]
  double yaw = 0;                                  ///< [rad]
  bool round = false;
  Material material = Material::wood;
  std::string name;  ///< "desk", "column", ... for messages and truth
  int piece = 0;     ///< blocks of one piece of furniture share a number; 0: of none
  int line = 0;
};

/// A place bounded by four walls, as truth: rectangle between the walls' faces.
struct Place {
  std::string name;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d width = Eigen::Vector2d::Zero();  ///< between the faces, along the place's own x and y [m]
  double yaw = 0;                                   ///< of its own x axis [rad]
  double z = 0;                                     ///< floor [m]
  double height = 0;                                ///< floor to ceiling [m]
};

/// A point that names the place around it.
struct PlaceSeed {
  std::string name;
  std::string kind;  ///< room, corridor, hall, open_plan
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  bool needs_region = false;  ///< walls must enclose it
  int line = 0;
};

/// A place of any outline, as truth: the floor between the faces of its walls.
struct Region {
  std::string name;
  std::string kind;
  std::vector<Eigen::Vector2d> outline;             ///< counter-clockwise
  std::vector<std::vector<Eigen::Vector2d>> holes;  ///< blocks of at least 1 m^2 that stand in it, walls around
  double area = 0;                                  ///< without small blocks [m^2]
};

/// How far a floor or ceiling is from flat: a slope and a few long waves. Height above the nominal one as a function of the place.
struct Unevenness {
  struct Wave {
    Eigen::Vector2d number = Eigen::Vector2d::Zero();  ///< [rad/m]
    double phase = 0;
    double amplitude = 0;  ///< [m]
  };
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  std::vector<Wave> waves;

  [[nodiscard]] double operator()(const Eigen::Vector2d& at) const;
  [[nodiscard]] bool flat() const { return slope.isZero(0) && waves.empty(); }
};

struct Storey {
  std::string name;
  double elevation = 0;  ///< world z of the floor [m]
  double height = 2.8;   ///< floor to ceiling [m]
  bool floor = true;
  bool ceiling = true;
  std::vector<std::vector<Eigen::Vector2d>> floor_voids;    ///< axis-parallel rectangles (low and high corner) cut out of the floor, ...
  std::vector<std::vector<Eigen::Vector2d>> ceiling_voids;  ///< ... and of the ceiling: stairwells, halls two storeys high
  Unevenness floor_shape;
  Unevenness ceiling_shape;
  std::vector<std::vector<Eigen::Vector2d>> outlines;  ///< of floor and ceiling, counter-clockwise; they may overlap
  std::vector<Wall> walls;
  std::vector<Block> columns;
  std::vector<Block> furniture;
  std::vector<Place> rooms;
  std::vector<Place> corridors;
  std::vector<PlaceSeed> seeds;
  std::vector<Region> regions;  ///< all places that its walls enclose, those with seeds first
};

/// Whether the floor of one storey lies on the ceiling of the other, with no slab between them.
bool stands_on(const Storey& above, const Storey& below);

/// A flight of stairs, or with `step` 0 a ramp: rises evenly from one end to the other.
struct Flight {
  Eigen::Vector3d begin = Eigen::Vector3d::Zero();  ///< middle of the foot of the first riser [m]
  Eigen::Vector3d end = Eigen::Vector3d::Zero();    ///< middle of the edge of the floor that it reaches, at that floor's height [m]
  double width = 1.2;                               ///< [m]
  double step = 0.17;                               ///< height of a step, about [m]
};

/// A landing between flights: a slab.
struct Landing {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  double z = 0;  ///< of its top [m]
};

/// A lift: a cabin that goes up and down in its shaft, with doors that shut. The shaft's walls and its doorways belong to the storeys.
struct Lift {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();   ///< corners of the cabin's inside, sides along x and y
  Eigen::Vector2d high = Eigen::Vector2d::Zero();  ///< [m]
  Eigen::Vector2d door = Eigen::Vector2d::Zero();  ///< middle of its doorway, on one of the sides
  double door_width = 0.9;                         ///< [m]
  double door_height = 2.0;                        ///< [m]
  double height = 2.2;                             ///< inside [m]
  std::vector<double> floors;                      ///< where it stops, world z [m]
};

/// Somebody who walks a line there and back.
struct Person {
  std::vector<Eigen::Vector2d> path;
  double speed = 1.0;  ///< [m/s]
  double offset = 0;   ///< along the path at the start [m]
  double height = 1.75;
  double z = 0;  ///< floor [m]
  int line = 0;
};

struct Waypoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double wait = 0;  ///< the robot stands here this long [s]; 0: it passes
  double z = 0;     ///< of the floor [m]; between waypoints it rises evenly: stairs, ramps
  int line = 0;
  std::optional<double> carried_to = std::nullopt;  ///< a lift takes the robot from here to this floor [m]
};

/// How the robot moves.
struct MotionProfile {
  double speed = 0.7;              ///< [m/s]
  double acceleration = 0.6;       ///< [m/s^2]
  double turn_rate = 0.9;          ///< [rad/s]
  double turn_acceleration = 2.0;  ///< [rad/s^2]
  double corner = 0.6;             ///< a turn begins this far before the corner [m]
  double base_height = 0.45;       ///< of base_link above the floor [m]
  double radius = 0.25;            ///< of the body, for the check of the route [m]
  double step_frequency = 2.0;     ///< steps a second: pitch and height swing with it, roll with half of it [Hz]
  double sway_roll = 0.01745;      ///< amplitudes while it walks [rad]
  double sway_pitch = 0.01396;     ///< [rad]
  double sway_height = 0.01;       ///< [m]
  double tilt = 0;                 ///< slow leaning to all sides while it walks [rad]
};

struct Route {
  std::vector<Waypoint> waypoints;  ///< all rounds written out
  double stand = 3.0;               ///< at the start [s]
  double stand_end = 1.0;           ///< at the end [s]
  double start_heading = 0;         ///< [rad]
  double duration = 0;              ///< when set, the robot's speed is chosen so that the run takes this long [s]
  std::size_t storey = 0;
};

/// How far a building is from its plan (docs/simulator.md, The real building). All zero: as planned.
struct BuildingErrors {
  std::uint64_t seed = 1;
  double lean = 0.3 * 0.017453292519943295;    ///< walls from the vertical, at most [rad]
  double square = 0.5 * 0.017453292519943295;  ///< walls from their planned direction, at most [rad]
  double shift = 0.03;                         ///< and no end of a wall by more than this [m]
  double bow = 0.004;                          ///< middle of a wall off the line through its ends, at most [m]
  double slope = 0.001;                        ///< of floors and ceilings
  double undulation = 0.004;                   ///< their waves, peak to peak [m]
};

/// A piece of furniture that stands elsewhere than the world's file says.
struct FurnitureMove {
  std::string name;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
};

/// What a later session changes.
struct Session {
  std::uint64_t seed = 0;  ///< 0: the world as in its file
  std::vector<FurnitureMove> moved;
  std::vector<Eigen::Vector2d> closed_doors;  ///< their middles
};

/// A building, who walks in it, and the robot's route. Right-handed, z up, metres, one frame ("world").
struct World {
  std::string name;
  std::string file;  ///< for messages
  std::vector<Storey> storeys;
  std::vector<Flight> flights;
  std::vector<Landing> landings;
  std::vector<Lift> lifts;
  std::vector<Person> people;
  Route route;
  MotionProfile motion;
  Pose T_base_lidar{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.15, 0.0, 0.25)};
  bool ground = true;     ///< ground around the building, seen through windows
  Session session;        ///< what was changed in it
  BuildingErrors errors;  ///< of the building where it is not to be as planned
};

/// Reads a world file (schema: docs/worlds.md). Throws WorldError with file, line and what is wrong: unknown keys, values out of range, openings off
/// the wall, rooms that no walls bound, a route or a person that passes through something.
World read_world(const std::string& path);

/// The same from text; `extends` is taken relative to `directory`.
World parse_world(const std::string& text, const std::string& file = "world", const std::string& directory = ".");

/// The world with the errors of its building (`world.errors`) built in: walls turned about their middle, leaning and bowed, joined as before; floors
/// and ceilings sloped and wavy; columns and furniture standing on them; rooms measured anew between the walls. Throws WorldError where the route
/// does not fit any more.
World with_building_errors(const World& world);

/// Steps of the flights as blocks, landings as blocks; ramps as very low steps, or not at all without `ramps`.
std::vector<Block> stairs_of(const World& world, bool ramps);

/// The same building on another day: the route the other way about from another start and with another heading, three pieces of furniture in ten
/// moved by 0.3 to 1 m, one door in four shut (what lies behind it is left out of the route) - each as far as the robot still gets through.
/// Deterministic.
World with_session(const World& world, std::uint64_t seed);

/// A bare box of the given inner size with its centre at the origin; the robot stands at the centre, or walks `route` when it is given. For tests.
World box_world(double length, double width, double height = 2.8, const std::vector<Eigen::Vector2d>& route = {});

}  // namespace sgraph::sim
