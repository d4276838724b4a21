#include "sgraph_slam/core/io/pcd.hpp"

#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sgraph_slam/core/io/file.hpp"

namespace sgraph {

namespace {

/// One of x, y and z in a point.
struct Axis {
  std::size_t offset = 0;  // of a binary point [byte]
  std::size_t column = 0;  // of an ascii line
  std::size_t size = 0;    // 4 or 8 bytes; 0: there is no such field
};

struct Header {
  std::array<Axis, 3> axes;
  std::size_t step = 0;     // bytes of a binary point
  std::size_t columns = 0;  // words of an ascii line
  std::size_t points = 0;
  bool ascii = false;
};

/// PCL's own reader trusts the header: one that contradicts itself makes it write beyond its buffers.
class PcdReader {
 public:
  explicit PcdReader(std::string_view bytes) : rest_(bytes) {}

  std::vector<Eigen::Vector3f> read() {
    read_header();
    std::vector<Eigen::Vector3f> points;
    const auto keep = [&points](const Eigen::Vector3f& point) {
      if (point.allFinite()) points.push_back(point);
    };
    if (header_.ascii) {
      read_ascii(keep);
    } else {
      read_binary(keep);
    }
    return points;
  }

 private:
  using Words = std::vector<std::string>;

  static std::size_t number(const std::string& word) {
    std::uint32_t value = 0;  // no cloud has more; products of two fit into 64 bits
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) throw std::runtime_error("a number is wanted in place of '" + word + "'");
    return value;
  }

  std::optional<std::string_view> line() {
    if (rest_.empty()) return std::nullopt;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    const std::string_view text = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return text;
  }

  static Words split(std::string_view text) {
    std::istringstream stream{std::string(text)};
    Words words;
    for (std::string word; stream >> word;) words.push_back(word);
    return words;
  }

  void read_header() {
    Words fields, sizes, types, counts;
    std::size_t width = 0, height = 1;
    std::optional<std::size_t> points;
    while (const auto text = line()) {
      Words words = split(*text);
      if (words.empty() || words.front()[0] == '#') continue;
      const std::string key = words.front();
      words.erase(words.begin());
      if (key == "VERSION" || key == "VIEWPOINT") continue;
      if (words.empty()) throw std::runtime_error(key + " has no value");
      if (key == "FIELDS" || key == "COLUMNS") {
        fields = words;
      } else if (key == "SIZE") {
        sizes = words;
      } else if (key == "TYPE") {
        types = words;
      } else if (key == "COUNT") {
        counts = words;
      } else if (key == "WIDTH") {
        width = number(words[0]);
      } else if (key == "HEIGHT") {
        height = number(words[0]);
      } else if (key == "POINTS") {
        points = number(words[0]);
      } else if (key == "DATA") {
        if (words[0] != "ascii" && words[0] != "binary") throw std::runtime_error("its encoding is " + words[0] + "; ascii and binary can be read");
        header_.ascii = words[0] == "ascii";
        header_.points = points.value_or(width * height);
        if (points && width * height != *points) throw std::runtime_error("WIDTH times HEIGHT is not POINTS");
        return lay_out(fields, sizes, types, counts);
      } else {
        throw std::runtime_error("it has an unknown line " + key);
      }
    }
    throw std::runtime_error("its header doesn't end");
  }

  void lay_out(const Words& fields, const Words& sizes, const Words& types, const Words& counts) {
    if (sizes.size() != fields.size() || types.size() != fields.size() || (!counts.empty() && counts.size() != fields.size()))
      throw std::runtime_error("FIELDS, SIZE, TYPE and COUNT differ in length");
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const std::size_t size = number(sizes[i]);
      const std::size_t count = counts.empty() ? 1 : number(counts[i]);
      if (fields[i].size() == 1 && fields[i][0] >= 'x' && fields[i][0] <= 'z') {
        if (types[i] != "F" || (size != 4 && size != 8) || count != 1) throw std::runtime_error(fields[i] + " is no floating-point number");
        header_.axes[static_cast<std::size_t>(fields[i][0] - 'x')] = {header_.step, header_.columns, size};
      }
      header_.step += size * count;
      header_.columns += count;
      if (header_.step > std::numeric_limits<std::uint32_t>::max()) throw std::runtime_error("its points have too many bytes");
    }
    for (const Axis& axis : header_.axes)
      if (axis.size == 0) throw std::runtime_error("it has no x, y and z");
  }

  template <class Keep>
  void read_binary(const Keep& keep) {
    if (header_.points > rest_.size() / header_.step)
      throw std::runtime_error(std::to_string(header_.points) + " points are announced, " + std::to_string(rest_.size() / header_.step) + " came");
    for (std::size_t i = 0; i < header_.points; ++i) {
      Eigen::Vector3f point;
      for (std::size_t a = 0; a < 3; ++a) {
        const char* at = rest_.data() + i * header_.step + header_.axes[a].offset;
        double value = 0;
        float small = 0;
        if (header_.axes[a].size == 8) {
          std::memcpy(&value, at, sizeof value);
          small = static_cast<float>(value);
        } else {
          std::memcpy(&small, at, sizeof small);
        }
        point[static_cast<Eigen::Index>(a)] = small;
      }
      keep(point);
    }
  }

  template <class Keep>
  void read_ascii(const Keep& keep) {
    for (std::size_t i = 0; i < header_.points; ++i) {
      const auto text = line();
      if (!text) throw std::runtime_error(std::to_string(header_.points) + " points are announced, " + std::to_string(i) + " came");
      const Words words = split(*text);
      if (words.size() != header_.columns)
        throw std::runtime_error("point " + std::to_string(i) + " has " + std::to_string(words.size()) + " values");
      Eigen::Vector3f point;
      for (std::size_t a = 0; a < 3; ++a) {
        const std::string& word = words[header_.axes[a].column];
        float value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error == std::errc::invalid_argument || end != word.data() + word.size())
          throw std::runtime_error("a number is wanted in place of '" + word + "'");
        point[static_cast<Eigen::Index>(a)] = error == std::errc() ? value : std::numeric_limits<float>::quiet_NaN();
      }
      keep(point);
    }
  }

  std::string_view rest_;
  Header header_;
};

}  // namespace

std::vector<Eigen::Vector3f> read_pcd_positions(const std::string& path) {
  const std::string bytes = read_file(path);
  try {
    return PcdReader(bytes).read();
  } catch (const std::exception& error) {
    throw std::runtime_error("cannot read " + path + " as a point cloud: " + error.what());
  }
}

}  // namespace sgraph
