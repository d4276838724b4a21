#pragma once

#include <string>

namespace sgraph {

/// World file of two storeys of 10 x 6 m with a lift in the room at x from 7 to 10; on the upper one a wall with a door in it stands at x = `wall`.
inline std::string building_with_lift(const std::string& wall, const std::string& route) {
  return R"(
storeys:
  - elevation: 0
    height: 2.8
    walls: [[[0, 0], [10, 0], [10, 6], [0, 6], [0, 0]], [[7, 0], [7, 6]]]
    doors: [{at: [7, 3], width: 1.0, top: 2.0}]
  - elevation: 3.2
    height: 2.8
    walls: [[[0, 0], [10, 0], [10, 6], [0, 6], [0, 0]], [[7, 0], [7, 6]], [[)" +
         wall + ", 0], [" + wall + R"(, 6]]]
    doors: [{at: [7, 3], width: 1.0, top: 2.0}, [)" +
         wall + R"(, 3]]
lifts: [{low: [7.2, 2.2], high: [9, 3.8], door: [7.2, 3], door_width: 1.0}]
route: )" +
         route + "\n";
}

}  // namespace sgraph
