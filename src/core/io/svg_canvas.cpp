#include <iomanip>
#include <sstream>

#include "canvas.hpp"

namespace sgraph {
namespace {

std::string hex(Color color) {
  std::ostringstream text;
  text << '#' << std::hex << std::setfill('0') << std::setw(2) << int{color.r} << std::setw(2) << int{color.g} << std::setw(2) << int{color.b};
  return text.str();
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return result;
}

class SvgCanvas : public Canvas {
 public:
  SvgCanvas(int width, int height) {
    out_ << std::fixed << std::setprecision(1);
    out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << height << "\" viewBox=\"0 0 " << width << ' ' << height
         << "\" font-family=\"Helvetica, Arial, sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  }

  void fill(const Points& polygon, Color color) override { fill_all({polygon}, color); }

  void fill_without_holes(const std::vector<Points>& loops, Color color) override {
    out_ << "<path fill-rule=\"evenodd\" fill=\"" << hex(color) << "\" d=\"";
    for (const Points& loop : loops) path(loop, true);
    out_ << "\"/>\n";
  }

  void fill_all(const std::vector<Points>& polygons, Color color) override {
    if (polygons.empty()) return;
    out_ << "<path fill=\"" << hex(color) << "\" d=\"";
    for (const Points& polygon : polygons) path(polygon, true);
    out_ << "\"/>\n";
  }

  void line(const Points& points, Color color, double width) override { stroke(points, color, width, ""); }

  void dashed(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Color color, double width) override {
    stroke({from, to}, color, width, " stroke-dasharray=\"6 6\"");
  }

  void disc(const Eigen::Vector2d& center, double radius, Color color) override {
    out_ << "<circle cx=\"" << center.x() << "\" cy=\"" << center.y() << "\" r=\"" << radius << "\" fill=\"" << hex(color)
         << "\" stroke=\"#ffffff\" stroke-width=\"2\"/>\n";
  }

  void text(const Eigen::Vector2d& at, const std::string& text, double size, Color color, Anchor anchor, bool bold) override {
    const char* anchors[] = {"start", "middle", "end"};
    out_ << "<text x=\"" << at.x() << "\" y=\"" << at.y() << "\" font-size=\"" << size << "\" fill=\"" << hex(color) << "\" text-anchor=\""
         << anchors[static_cast<int>(anchor)] << "\" stroke=\"#ffffff\" stroke-width=\"4\" stroke-linejoin=\"round\" paint-order=\"stroke\""
         << (bold ? " font-weight=\"bold\"" : "") << '>' << escaped(text) << "</text>\n";
  }

  [[nodiscard]] std::string bytes() const override { return out_.str() + "</svg>\n"; }

 private:
  void path(const Points& points, bool closed) {
    for (std::size_t i = 0; i < points.size(); ++i) out_ << (i == 0 ? 'M' : 'L') << points[i].x() << ' ' << points[i].y();
    if (closed) out_ << 'Z';
  }

  void stroke(const Points& points, Color color, double width, const char* more) {
    if (points.size() < 2) return;
    out_ << "<path fill=\"none\" stroke=\"" << hex(color) << "\" stroke-width=\"" << width << "\" stroke-linecap=\"round\" stroke-linejoin=\"round\""
         << more << " d=\"";
    path(points, false);
    out_ << "\"/>\n";
  }

  std::ostringstream out_;
};

}  // namespace

std::unique_ptr<Canvas> svg_canvas(int width, int height) { return std::make_unique<SvgCanvas>(width, height); }

}  // namespace sgraph
