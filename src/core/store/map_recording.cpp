#include "sgraph_slam/core/store/map_recording.hpp"

#include <filesystem>

namespace sgraph {
namespace {

constexpr std::chrono::seconds patience{60};  // for a slow disk at the end of a recording

}  // namespace

MapRecording::MapRecording(const std::string& path, StoredSession session) : path_(path), aside_(set_aside(path)) {
  store_.emplace(path, MapStore::Mode::create, std::move(session));
  recorder_.emplace(*store_);
}

MapRecording::MapRecording(const std::string& path, StoredSession session, const std::string& from, const StoredMap& known) : path_(path) {
  std::error_code error;
  if (!std::filesystem::equivalent(path, from, error)) {
    aside_ = set_aside(path);
    copy_map(from, path);
  }
  store_.emplace(path, MapStore::Mode::extend, std::move(session));
  recorder_.emplace(*store_, known);
}

RecordingFigures MapRecording::finish() {
  const bool complete = store_->flush(patience);
  RecordingFigures figures{path_, 0, store_->cpu_seconds()};
  const std::string problem = store_->problem();
  recorder_.reset();
  store_.reset();
  if (!complete) throw StoreError((problem.empty() ? path_ + ": the disk is too slow" : problem) + "; the map file is not complete");
  std::error_code error;
  figures.bytes = static_cast<double>(std::filesystem::file_size(path_, error));
  if (!aside_.empty()) std::filesystem::remove(aside_, error);
  return figures;
}

}  // namespace sgraph
