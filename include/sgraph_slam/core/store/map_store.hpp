#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/store/store_error.hpp"
#include "sgraph_slam/core/types/decision.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// The schema that this program writes; it reads all older ones.
constexpr int store_schema = 2;

/// One recording, or one time that the robot was switched on, in a map.
struct StoredSession {
  std::int64_t id = 0;
  std::string source;                   ///< what was mapped: the bags, the topic
  std::string sensor;                   ///< frame of the clouds
  Stamp started;                        ///< stamp of its first keyframe
  Pose T_base_lidar;                    ///< pose of the LiDAR on the robot
  std::string frame = "map";            ///< in which the poses are
  std::string parameters;               ///< in force, YAML
  std::string program = "sgraph_slam";  ///< that wrote it
  std::string localisation;             ///< how it was joined to the map before it, JSON; empty for the first
};

/// What the map knows of a plane beside its views.
struct StoredPlane {
  PlaneId id;
  Plane plane;  ///< map frame
  PlaneClass plane_class = PlaneClass::unclassified;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();       ///< as readers see it
  Eigen::Matrix3d view_covariance = Eigen::Matrix3d::Zero();  ///< of the newest view given its keyframe
  std::vector<Eigen::Vector3d> extent;                        ///< map frame
};

/// One view of a plane; which plane, its factor tells.
struct StoredView {
  FactorId factor;
  KeyframeId keyframe;
  std::vector<Eigen::Vector3d> extent;  ///< in the keyframe's base frame
};

/// A keyframe that saw a plane and keeps no view of it: it has been retired.
struct StoredSighting {
  PlaneId plane;
  KeyframeId keyframe;
};

/// What has changed in a map: written as a whole or not at all.
struct StoreBatch {
  std::vector<Keyframe> keyframes;  ///< new ones, with their clouds
  std::vector<KeyframeId> clouds_let_go;
  std::vector<std::pair<KeyframeId, Pose>> poses;
  std::vector<StoredPlane> planes;
  std::vector<PlaneId> removed_planes;
  std::vector<StoredView> views;
  std::vector<StoredSighting> sightings;
  std::map<FactorId, Factor> factors;
  std::vector<FactorId> removed_factors;
  std::map<PlaneId, MergeRecord> merges;
  std::vector<PlaneId> removed_merges;
  std::vector<Decision> decisions;               ///< further ones
  std::map<std::string, std::string> documents;  ///< by name: what is kept as one text

  [[nodiscard]] bool empty() const;
};

/// A map file being written, by a thread of its own. A batch is one SQLite transaction (write-ahead log, synchronous): whatever ends the program or
/// the machine, the file holds every batch that was written, and no half ones. All functions may be called from any thread.
class MapStore {
 public:
  enum class Mode {
    create,  ///< a new file; one that is there is refused
    extend,  ///< a further session in a file that is there
  };

  /// Throws StoreError when the file cannot be made or taken up. `failed` is called on the store's thread, once for each new reason why nothing can
  /// be written: what waits is tried again with the next batch and every second.
  MapStore(const std::string& path, Mode mode, StoredSession session, std::function<void(const std::string&)> failed = {});
  /// Writes what waits, for at most ten seconds.
  ~MapStore();
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  void write(StoreBatch batch);

  /// Waits until all is written; false when that fails or takes longer.
  bool flush(std::chrono::milliseconds limit);

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Batches that wait.
  [[nodiscard]] std::size_t waiting() const;
  /// Why nothing can be written at the moment; empty when all is well.
  [[nodiscard]] std::string problem() const;
  /// CPU time of the thread so far [s].
  [[nodiscard]] double cpu_seconds() const;

 private:
  class File;
  void run();
  void write_waiting(std::unique_lock<std::mutex>& lock);

  const std::string path_;
  const std::function<void(const std::string&)> failed_;
  std::unique_ptr<File> file_;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  std::deque<StoreBatch> waiting_;
  std::string problem_;
  std::size_t failures_ = 0;
  std::size_t asked_ = 0;  // calls of flush
  double cpu_seconds_ = 0;
  bool busy_ = false;
  bool stop_ = false;

  std::thread thread_;  // last: it uses all of the above
};

/// Files of one name that are kept aside.
constexpr std::size_t most_set_aside = 5;

/// Renames a file that is there to `<name>.before.sgmap`, or `<name>.before-2.sgmap` and so on: a map is never overwritten. Of these the newest
/// `most_set_aside` are kept; the oldest beyond them is removed, so that a robot that is switched on every day does not fill its disk. Returns the
/// new name; empty when there was none. Throws StoreError.
std::string set_aside(const std::string& path);

/// Copies a map file, also while it is being written, into a new one. Throws StoreError.
void copy_map(const std::string& from, const std::string& to);

}  // namespace sgraph
