#include "sgraph_slam/core/graph/g2o.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <stdexcept>

namespace sgraph {
namespace {

[[noreturn]] void fail(const std::string& path, int line, const std::string& reason) {
  throw std::runtime_error(path + ":" + std::to_string(line) + ": " + reason);
}

class Line {
 public:
  Line(const std::string& text, std::string path, int number) : stream_(text), path_(std::move(path)), number_(number) { stream_ >> tag; }

  KeyframeId id() {
    KeyframeId out;
    if (!(stream_ >> out.value) || !out.valid()) fail(path_, number_, "expected a vertex number");
    return out;
  }

  double real() {
    double out = 0;
    if (!(stream_ >> out) || !std::isfinite(out)) fail(path_, number_, "expected a finite number");
    return out;
  }

  Pose pose() {
    Pose out;
    for (int i = 0; i < 3; ++i) out.translation[i] = real();
    for (int i = 0; i < 4; ++i) out.rotation.coeffs()[i] = real();
    if (out.rotation.norm() < 1e-3) fail(path_, number_, "the quaternion is zero");
    out.rotation.normalize();
    return out;
  }

  // Upper triangle row by row, order x y z and rotation; ours is rotation, translation.
  SqrtInformation<6> information() {
    Matrix6 m;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) m((row + 3) % 6, (column + 3) % 6) = m((column + 3) % 6, (row + 3) % 6) = real();
    }
    return SqrtInformation<6>::from_information(m);
  }

  std::string tag;

 private:
  std::istringstream stream_;
  std::string path_;
  int number_;
};

SqrtInformation<6> isotropic(const SqrtInformation<6>& weight) {
  const Matrix6 covariance = weight.information().inverse();
  Vector6 std_dev;
  std_dev.head<3>().setConstant(std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3.0));
  std_dev.tail<3>().setConstant(std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3.0));
  return SqrtInformation<6>::from_std_dev(std_dev);
}

void write_pose(std::ostream& out, const Pose& pose) {
  for (int i = 0; i < 3; ++i) out << ' ' << pose.translation[i];
  for (int i = 0; i < 4; ++i) out << ' ' << pose.rotation.coeffs()[i];
}

}  // namespace

Graph read_g2o(const std::string& path, G2oWeights weights) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  Transaction edit;
  edit.reason = "read from " + path;
  std::string text;
  for (int number = 1; std::getline(file, text); ++number) {
    Line line(text, path, number);
    if (line.tag == "VERTEX_SE3:QUAT") {
      const KeyframeId id = line.id();
      if (!edit.keyframes.emplace(id, line.pose()).second) fail(path, number, "vertex " + std::to_string(id.value) + " is given twice");
    } else if (line.tag == "EDGE_SE3:QUAT") {
      Se3Between between;
      between.from = line.id();
      between.to = line.id();
      if (between.from == between.to) fail(path, number, "edge from a vertex to itself");
      between.T_from_to = line.pose();
      between.weight = line.information();
      if (weights == G2oWeights::isotropic) between.weight = isotropic(between.weight);
      const bool next = between.to.value == between.from.value + 1;
      between.source = next ? Se3Between::Source::odometry : Se3Between::Source::loop;
      edit.factors.push_back({between, {}});
    } else if (!line.tag.empty() && line.tag[0] != '#' && line.tag != "FIX") {
      fail(path, number, "unknown entry '" + line.tag + "'");
    }
  }
  if (edit.factors.empty()) throw std::runtime_error(path + ": no EDGE_SE3:QUAT in it");
  for (const Factor& factor : edit.factors) {
    const auto& between = std::get<Se3Between>(factor.data);
    edit.keyframes.emplace(between.from, Pose{});
    edit.keyframes.emplace(between.to, Pose{});
  }
  Graph graph;
  const Applied applied = graph.apply(edit);
  if (!applied.ok()) throw std::runtime_error(path + ": " + applied.detail);
  return graph;
}

void write_g2o(const std::string& path, const Graph& graph) {
  std::ofstream file(path);
  file << std::setprecision(17);
  for (const auto& [id, pose] : graph.keyframes()) {
    file << "VERTEX_SE3:QUAT " << id.value;
    write_pose(file, pose);
    file << '\n';
  }
  for (const auto& [id, factor] : graph.factors()) {
    const auto* between = std::get_if<Se3Between>(&factor.data);
    if (between == nullptr) continue;
    file << "EDGE_SE3:QUAT " << between->from.value << ' ' << between->to.value;
    write_pose(file, between->T_from_to);
    const Matrix6 information = between->weight.information();
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) file << ' ' << information((row + 3) % 6, (column + 3) % 6);
    }
    file << '\n';
  }
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace sgraph
