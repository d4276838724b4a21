#pragma once

#include <cstdint>
#include <vector>

#include "sgraph_slam/core/places/free_space.hpp"
#include "sgraph_slam/core/places/wall_lines.hpp"

namespace sgraph {

/// A window of the free space's raster, in cells.
struct CellWindow {
  int x = 0;  ///< of its first column
  int y = 0;
  int width = 0;
  int height = 0;
};

/// The free floor in pieces that walls and doors part.
struct Regions {
  int count = 0;
  CellWindow window;                ///< around the walls; nothing beyond it is a place
  std::vector<std::int32_t> label;  ///< by cell of the window, row by row: number of the region, -1 for none
  std::vector<CellWindow> extent;   ///< by region: the cells around it, counted as in the raster
  std::vector<char> entered;        ///< by region: the robot has been in it

  /// The region of a cell of the raster; -1 for none.
  [[nodiscard]] int at(int x, int y) const {
    if (x < window.x || y < window.y || x >= window.x + window.width || y >= window.y + window.height) return -1;
    return label[static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.width) + static_cast<std::size_t>(x - window.x)];
  }
};

/// Connected free cells that a disc of the robot's radius can pass between, parted by the solid stretches of the lines and by the gaps that are cut.
/// The rest of the free cells belongs to the piece that reaches it first. Pieces smaller than `params.min_area` are none. `used`: regions that nobody
/// needs any more; their memory is used again, as fresh memory for a label a cell takes longer than filling it.
Regions find_regions(const FreeSpace& space, const std::vector<WallLine>& lines, const std::vector<Eigen::Vector2d>& path, const PlaceParams& params,
                     Regions used = {});

}  // namespace sgraph
