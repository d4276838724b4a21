#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "canvas.hpp"

namespace sgraph {
namespace {

// Everything is drawn twice as large and halved at the end, which smooths edges that OpenCV leaves rough.
constexpr double zoom = 2;
constexpr int shift = 4;  // OpenCV takes 1/16 pixels

cv::Scalar bgr(Color color) { return cv::Scalar(color.b, color.g, color.r); }

class PngCanvas : public Canvas {
 public:
  PngCanvas(int width, int height) : image_(static_cast<int>(zoom) * height, static_cast<int>(zoom) * width, CV_8UC3, cv::Scalar(255, 255, 255)) {}

  void fill(const Points& polygon, Color color) override {
    const auto points = fixed(polygon);
    cv::fillPoly(image_, std::vector<std::vector<cv::Point>>{points}, bgr(color), cv::LINE_AA, shift);
  }

  void fill_without_holes(const std::vector<Points>& loops, Color color) override {
    std::vector<std::vector<cv::Point>> contours;
    for (const Points& loop : loops) contours.push_back(fixed(loop));
    cv::fillPoly(image_, contours, bgr(color), cv::LINE_AA, shift);
  }

  void fill_all(const std::vector<Points>& polygons, Color color) override {
    for (const Points& polygon : polygons) fill(polygon, color);
  }

  void line(const Points& points, Color color, double width) override {
    cv::polylines(image_, fixed(points), false, bgr(color), pixels(width), cv::LINE_AA, shift);
  }

  void dashed(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Color color, double width) override {
    constexpr double dash = 6;  // px
    const double length = (to - from).norm();
    for (double s = 0; s < length; s += 2 * dash) {
      line({from + s / length * (to - from), from + std::min(length, s + dash) / length * (to - from)}, color, width);
    }
  }

  void disc(const Eigen::Vector2d& center, double radius, Color color) override {
    cv::circle(image_, fixed(center), fixed(radius + 2), cv::Scalar(255, 255, 255), cv::FILLED, cv::LINE_AA, shift);
    cv::circle(image_, fixed(center), fixed(radius), bgr(color), cv::FILLED, cv::LINE_AA, shift);
  }

  void text(const Eigen::Vector2d& at, const std::string& text, double size, Color color, Anchor anchor, bool bold) override {
    constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
    constexpr double letter_box = 30;  // px at scale 1
    const double scale = zoom * size / letter_box;
    const int weight = pixels(size / 14 * (bold ? 1.5 : 1.0));
    int base_line = 0;
    const double width = cv::getTextSize(text, font, scale, weight, &base_line).width;
    const double share = anchor == Anchor::left ? 0 : anchor == Anchor::middle ? 0.5 : 1;
    const cv::Point corner(static_cast<int>(zoom * at.x() - share * width), static_cast<int>(zoom * at.y()));
    cv::putText(image_, text, corner, font, scale, cv::Scalar(255, 255, 255), weight + pixels(4), cv::LINE_AA);
    cv::putText(image_, text, corner, font, scale, bgr(color), weight, cv::LINE_AA);
  }

  [[nodiscard]] std::string bytes() const override {
    cv::Mat small;
    cv::resize(image_, small, {}, 1 / zoom, 1 / zoom, cv::INTER_AREA);
    std::vector<std::uint8_t> bytes;
    if (!cv::imencode(".png", small, bytes)) throw std::runtime_error("the picture can't be encoded as PNG");
    return {bytes.begin(), bytes.end()};
  }

 private:
  static int fixed(double value) { return static_cast<int>(std::lround(zoom * value * (1 << shift))); }
  static cv::Point fixed(const Eigen::Vector2d& p) { return {fixed(p.x()), fixed(p.y())}; }
  static std::vector<cv::Point> fixed(const Points& points) {
    std::vector<cv::Point> result;
    for (const auto& p : points) result.push_back(fixed(p));
    return result;
  }
  static int pixels(double width) { return std::max(1, static_cast<int>(std::lround(zoom * width))); }

  cv::Mat image_;
};

}  // namespace

std::unique_ptr<Canvas> png_canvas(int width, int height) { return std::make_unique<PngCanvas>(width, height); }

}  // namespace sgraph
