#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sgraph {

struct Color {
  std::uint8_t r, g, b;
};

enum class Anchor { left, middle, right };

/// A page to draw on, in pixels from its upper left corner.
class Canvas {
 public:
  using Points = std::vector<Eigen::Vector2d>;

  virtual ~Canvas() = default;

  virtual void fill(const Points& polygon, Color color) = 0;
  /// An outline without what lies in the loops after it.
  virtual void fill_without_holes(const std::vector<Points>& loops, Color color) = 0;
  /// Many small polygons of one colour.
  virtual void fill_all(const std::vector<Points>& polygons, Color color) = 0;
  virtual void line(const Points& points, Color color, double width) = 0;
  virtual void dashed(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Color color, double width) = 0;
  virtual void disc(const Eigen::Vector2d& center, double radius, Color color) = 0;
  /// ASCII text; `at` is on its base line, `size` the height of its letters' box. It gets a white border, to be read on any ground.
  virtual void text(const Eigen::Vector2d& at, const std::string& text, double size, Color color, Anchor anchor, bool bold = false) = 0;
  /// The picture's file.
  [[nodiscard]] virtual std::string bytes() const = 0;
};

std::unique_ptr<Canvas> svg_canvas(int width, int height);
std::unique_ptr<Canvas> png_canvas(int width, int height);

}  // namespace sgraph
