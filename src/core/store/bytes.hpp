#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "sgraph_slam/core/types/plane.hpp"
#include "sgraph_slam/core/types/pose.hpp"

// Numbers are stored as this machine has them.
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "map files are little-endian"
#endif

namespace sgraph {

/// Values one after the other.
class ByteWriter {
 public:
  template <class T>
  void value(T number) {
    static_assert(std::is_arithmetic_v<T>);
    char raw[sizeof(T)];
    std::memcpy(raw, &number, sizeof(T));
    bytes_.append(raw, sizeof(T));
  }
  void bytes(std::string_view text) { bytes_.append(text); }
  void pose(const Pose& pose) {
    for (int k = 0; k < 3; ++k) value(pose.translation[k]);
    for (int k = 0; k < 4; ++k) value(pose.rotation.coeffs()[k]);
  }
  void points(const std::vector<Eigen::Vector3d>& points) {
    for (const auto& p : points) {
      for (int k = 0; k < 3; ++k) value(p[k]);
    }
  }
  template <class Derived>
  void matrix(const Eigen::MatrixBase<Derived>& m) {
    for (Eigen::Index r = 0; r < m.rows(); ++r) {
      for (Eigen::Index c = 0; c < m.cols(); ++c) value(static_cast<double>(m(r, c)));
    }
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads them back. Throws std::runtime_error beyond the end.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  T value() {
    T number;
    std::memcpy(&number, bytes(sizeof(T)).data(), sizeof(T));
    return number;
  }
  std::string_view bytes(std::size_t count) {
    if (count > bytes_.size()) throw std::runtime_error("damaged data");
    const std::string_view part = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return part;
  }
  Pose pose() {
    Pose pose;
    for (int k = 0; k < 3; ++k) pose.translation[k] = value<double>();
    for (int k = 0; k < 4; ++k) pose.rotation.coeffs()[k] = value<double>();
    if (!pose.translation.allFinite() || !(std::abs(pose.rotation.norm() - 1) < 1e-6)) throw std::runtime_error("a damaged pose");
    return pose;
  }
  std::vector<Eigen::Vector3d> points() {
    std::vector<Eigen::Vector3d> points(bytes_.size() / (3 * sizeof(double)));
    for (auto& p : points) {
      for (int k = 0; k < 3; ++k) p[k] = value<double>();
    }
    return points;
  }
  template <int Rows, int Columns>
  Eigen::Matrix<double, Rows, Columns> matrix() {
    Eigen::Matrix<double, Rows, Columns> m;
    for (Eigen::Index r = 0; r < Rows; ++r) {
      for (Eigen::Index c = 0; c < Columns; ++c) m(r, c) = value<double>();
    }
    return m;
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

/// Zstandard with a checksum, fast level.
std::string compressed(std::string_view bytes);
/// Throws std::runtime_error when the bytes are damaged.
std::string decompressed(std::string_view bytes);

}  // namespace sgraph
