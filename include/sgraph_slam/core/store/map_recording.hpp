#pragma once

#include <optional>
#include <string>

#include "sgraph_slam/core/store/map_recorder.hpp"
#include "sgraph_slam/core/store/map_store.hpp"

namespace sgraph {

/// What writing a map took.
struct RecordingFigures {
  std::string path;
  double bytes = 0;
  double cpu_seconds = 0;  ///< of the store's thread
};

/// A map file written while a map grows, for programs that map a recording from end to end. A file of that name is kept aside until the new one is
/// complete.
class MapRecording {
 public:
  /// Throws StoreError when the file cannot be made.
  MapRecording(const std::string& path, StoredSession session);

  /// A further session of the map in `from`, of which `known` is what it holds: written into a copy of it, or into the file itself when `path` is the
  /// same. Throws StoreError.
  MapRecording(const std::string& path, StoredSession session, const std::string& from, const StoredMap& known);

  /// To be shown the map.
  [[nodiscard]] MapObserver& observer() { return *recorder_; }

  /// Ends the file once all is written, and removes the one that was kept aside. Throws StoreError when something could not be written; what could be
  /// is in the file then, and the older one stays.
  RecordingFigures finish();

 private:
  std::string path_;
  std::string aside_;
  std::optional<MapStore> store_;
  std::optional<MapRecorder> recorder_;
};

}  // namespace sgraph
