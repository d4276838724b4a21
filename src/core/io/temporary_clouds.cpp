#include "sgraph_slam/core/io/temporary_clouds.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

namespace sgraph {
namespace {

constexpr std::size_t point_bytes = 22;      // x y z intensity time as floats, ring
constexpr std::size_t viewpoint_bytes = 32;  // time, position

template <class T>
void put_in(char*& at, const T& value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}

template <class T>
T take(const char*& at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

std::string packed(const Cloud& cloud) {
  std::string bytes(32 + cloud.frame.size() + point_bytes * cloud.size() + viewpoint_bytes * cloud.viewpoints.size(), '\0');
  char* at = bytes.data();
  put_in(at, std::int64_t{cloud.stamp.nanoseconds});
  put_in(at, std::uint64_t{cloud.frame.size()});
  put_in(at, std::uint64_t{cloud.points.size()});
  put_in(at, std::uint64_t{cloud.viewpoints.size()});
  at = std::copy(cloud.frame.begin(), cloud.frame.end(), at);
  for (const Point& p : cloud.points) {
    put_in(at, std::array<float, 5>{p.x, p.y, p.z, p.intensity, p.time});
    put_in(at, p.ring);
  }
  for (const Viewpoint& v : cloud.viewpoints) put_in(at, std::array<double, 4>{v.time, v.position.x(), v.position.y(), v.position.z()});
  return bytes;
}

CloudPtr unpacked(const std::string& bytes) {
  const char* at = bytes.data();
  auto cloud = std::make_shared<Cloud>();
  cloud->stamp.nanoseconds = take<decltype(cloud->stamp.nanoseconds)>(at);
  const auto name = take<std::uint64_t>(at);
  cloud->points.resize(take<std::uint64_t>(at));
  cloud->viewpoints.resize(take<std::uint64_t>(at));
  cloud->frame.assign(at, name);
  at += name;
  for (Point& p : cloud->points) {
    const auto values = take<std::array<float, 5>>(at);
    p = {values[0], values[1], values[2], values[3], values[4], take<std::uint16_t>(at)};
  }
  for (Viewpoint& v : cloud->viewpoints) {
    const auto values = take<std::array<double, 4>>(at);
    v = {values[0], {values[1], values[2], values[3]}};
  }
  return cloud;
}

// A file without a name in the folder; its number, or -1 with errno set.
int open_nameless(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return file;
  std::string name = folder + "/sgraph_clouds_XXXXXX";  // a file system that can't: made with a name, which goes at once
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

// Whether all was written.
bool write_all(int file, const std::string& bytes, std::int64_t offset) {
  for (std::size_t done = 0; done < bytes.size();) {
    const auto written = ::pwrite(file, bytes.data() + done, bytes.size() - done, offset + static_cast<std::int64_t>(done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    done += static_cast<std::size_t>(written);
  }
  return true;
}

std::optional<std::string> read_all(int file, std::size_t count, std::int64_t offset) {
  std::string bytes(count, '\0');
  for (std::size_t done = 0; done < count;) {
    const auto got = ::pread(file, bytes.data() + done, count - done, offset + static_cast<std::int64_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return std::nullopt;
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

std::string reason(const std::string& folder) { return folder + ": " + std::generic_category().message(errno); }

}  // namespace

TemporaryClouds::TemporaryClouds(const std::string& folder, std::size_t cached) : cached_(cached) {
  std::error_code none;
  const std::string where = folder.empty() ? std::filesystem::temp_directory_path(none).string() : folder;
  file_ = open_nameless(where);
  if (file_ < 0) failure_ = reason(where);
}

TemporaryClouds::~TemporaryClouds() {
  if (file_ >= 0) ::close(file_);
}

void TemporaryClouds::put(KeyframeId id, const CloudPtr& cloud) {
  const std::lock_guard<std::mutex> lock(mutex_);
  newest_.remove_if([id](const auto& entry) { return entry.first == id; });
  unwritten_.erase(id);
  if (const auto place = places_.find(id); place != places_.end()) {
    // Gives its blocks back to the disk; where the file system can't, they are lost until the end.
    if (!cloud) ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, place->second.offset, static_cast<off_t>(place->second.bytes));
    places_.erase(place);
  }
  if (!cloud) return;
  if (file_ < 0) {
    unwritten_[id] = cloud;
    return;
  }
  const std::string bytes = packed(*cloud);
  if (write_all(file_, bytes, end_)) {
    places_[id] = {end_, bytes.size()};
    end_ += static_cast<std::int64_t>(bytes.size());
    remember(id, cloud);
  } else {
    failure_ = reason("clouds of keyframes");
    unwritten_[id] = cloud;
  }
}

CloudPtr TemporaryClouds::get(KeyframeId id) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto kept = unwritten_.find(id);
  if (kept != unwritten_.end()) return kept->second;
  const auto cached = std::find_if(newest_.begin(), newest_.end(), [id](const auto& entry) { return entry.first == id; });
  if (cached != newest_.end()) {
    newest_.splice(newest_.begin(), newest_, cached);
    return cached->second;
  }
  const auto place = places_.find(id);
  if (place == places_.end()) return nullptr;
  const auto bytes = read_all(file_, place->second.bytes, place->second.offset);
  if (!bytes) return nullptr;
  CloudPtr cloud = unpacked(*bytes);
  remember(id, cloud);
  return cloud;
}

void TemporaryClouds::remember(KeyframeId id, const CloudPtr& cloud) const {
  newest_.emplace_front(id, cloud);
  while (newest_.size() > cached_) newest_.pop_back();
}

std::string TemporaryClouds::failure() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return failure_;
}

std::size_t TemporaryClouds::in_memory() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_.size() + unwritten_.size();
}

}  // namespace sgraph
