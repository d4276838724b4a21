#include "sgraph_slam/core/store/map_store.hpp"

#include <ctime>
#include <filesystem>
#include <optional>

#include "bytes.hpp"
#include "database.hpp"
#include "schema.hpp"
#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/store/cloud_codec.hpp"

namespace sgraph {
namespace {

constexpr std::chrono::seconds retry{1};     // after a failure
constexpr std::chrono::seconds parting{10};  // for what waits at the end
constexpr std::size_t most_batches = 50;     // in one transaction

double thread_cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string pose_bytes(const Pose& pose) {
  ByteWriter out;
  out.pose(pose);
  return out.take();
}

template <class Derived>
std::string matrix_bytes(const Eigen::MatrixBase<Derived>& matrix) {
  ByteWriter out;
  out.matrix(matrix);
  return out.take();
}

std::string points_bytes(const std::vector<Eigen::Vector3d>& points) {
  ByteWriter out;
  out.points(points);
  return out.take();
}

std::string scans_bytes(const Trajectory& scans) {
  ByteWriter out;
  for (const StampedPose& scan : scans) {
    out.value(scan.stamp.nanoseconds);
    out.pose(scan.pose);
  }
  return out.take();
}

std::string directions_bytes(const std::vector<Vector6>& directions) {
  ByteWriter out;
  for (const Vector6& v : directions) out.matrix(v);
  return out.take();
}

std::string plane_bytes(const Plane& plane) { return matrix_bytes(Eigen::Vector4d(plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.d)); }

}  // namespace

bool StoreBatch::empty() const {
  return keyframes.empty() && clouds_let_go.empty() && poses.empty() && planes.empty() && removed_planes.empty() && views.empty() &&
         sightings.empty() && factors.empty() && removed_factors.empty() && merges.empty() && removed_merges.empty() && decisions.empty() &&
         documents.empty();
}

/// The file and its prepared statements; used by the constructor, then by the thread alone.
class MapStore::File {
 public:
  File(const std::string& path, Mode mode, StoredSession session)
      : database_(path, mode == Mode::create ? Access::create : Access::write), session_(std::move(session)) {
    if (mode == Mode::create) {
      if (database_.number("SELECT count(*) FROM sqlite_master") > 0) throw StoreError(path + ": it exists already");
      database_.execute("PRAGMA page_size = 8192");
    } else {
      check_schema(database_);
      if (const std::string fault = database_.text("PRAGMA quick_check(1)"); fault != "ok")
        throw StoreError(path + ": the file is damaged (" + fault + ")");
      session_.id = 1 + database_.number("SELECT max(id) FROM sessions");
    }
    database_.execute("PRAGMA journal_mode = WAL");
    database_.execute("PRAGMA synchronous = FULL");
    if (mode == Mode::create) {
      make_schema(database_);
    } else {
      migrate_schema(database_);
    }
    statements_.emplace(database_);
  }

  // A finished map is one file that can be read from a read-only folder too.
  ~File() {
    statements_.reset();
    try {
      database_.execute("PRAGMA journal_mode = DELETE");
    } catch (const StoreError&) {  // somebody reads it: the log stays and belongs to it
    }
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void write(const std::deque<StoreBatch>& batches) {
    DatabaseTransaction transaction(database_);
    for (const StoreBatch& batch : batches) write(batch);
    transaction.commit();
    session_written_ = session_written_ || session_in_transaction_;
  }

 private:
  struct Statements {
    explicit Statements(Database& d)
        : session(d, "INSERT OR REPLACE INTO sessions VALUES(?,?,?,?,?,?,?,?,?)"),
          keyframe(d, "INSERT OR REPLACE INTO keyframes VALUES(?,?,?,?,?,?,?)"),
          cloud(d, "INSERT OR REPLACE INTO clouds VALUES(?,?,?)"),
          no_cloud(d, "DELETE FROM clouds WHERE keyframe = ?"),
          pose(d, "INSERT OR REPLACE INTO poses VALUES(?,?)"),
          plane(d, "INSERT OR REPLACE INTO planes VALUES(?,?,?,?,?,?)"),
          no_plane(d, "DELETE FROM planes WHERE id = ?"),
          view(d, "INSERT OR REPLACE INTO views VALUES(?,?,?)"),
          sighting(d, "INSERT OR IGNORE INTO sightings VALUES(?,?)"),
          factor(d, "INSERT OR REPLACE INTO factors VALUES(?,?)"),
          no_factor(d, "DELETE FROM factors WHERE id = ?"),
          no_view(d, "DELETE FROM views WHERE factor = ?"),
          merge(d, "INSERT OR REPLACE INTO merges VALUES(?,?)"),
          no_merge(d, "DELETE FROM merges WHERE merged = ?"),
          decision(d, "INSERT INTO decisions(keyframe, accepted, what, reason) VALUES(?,?,?,?)"),
          document(d, "INSERT OR REPLACE INTO documents VALUES(?,?)") {}
    Statement session, keyframe, cloud, no_cloud, pose, plane, no_plane, view, sighting, factor, no_factor, no_view, merge, no_merge, decision,
        document;
  };

  void write(const StoreBatch& batch) {
    Statements& s = *statements_;
    if (!session_written_ && !batch.keyframes.empty()) {
      session_.started = batch.keyframes.front().stamp;
      write_session();
    }
    for (const Keyframe& keyframe : batch.keyframes) write(keyframe);
    for (const KeyframeId id : batch.clouds_let_go) s.no_cloud.bind(1, id.value).run();
    for (const auto& [id, pose] : batch.poses) s.pose.bind(1, id.value).bind_blob(2, pose_bytes(pose)).run();
    for (const StoredPlane& plane : batch.planes) {
      s.plane.bind(1, plane.id.value)
          .bind(2, std::string(to_string(plane.plane_class)))
          .bind_blob(3, plane_bytes(plane.plane))
          .bind_blob(4, matrix_bytes(plane.covariance))
          .bind_blob(5, matrix_bytes(plane.view_covariance))
          .bind_blob(6, points_bytes(plane.extent))
          .run();
    }
    for (const PlaneId id : batch.removed_planes) s.no_plane.bind(1, id.value).run();
    for (const StoredView& view : batch.views)
      s.view.bind(1, view.factor.value).bind(2, view.keyframe.value).bind_blob(3, points_bytes(view.extent)).run();
    for (const StoredSighting& sighting : batch.sightings) s.sighting.bind(1, sighting.plane.value).bind(2, sighting.keyframe.value).run();
    for (const auto& [id, factor] : batch.factors) s.factor.bind(1, id.value).bind(2, factor_to_json(id, factor)).run();
    for (const FactorId id : batch.removed_factors) {
      s.no_factor.bind(1, id.value).run();
      s.no_view.bind(1, id.value).run();
    }
    for (const auto& [id, record] : batch.merges) s.merge.bind(1, id.value).bind(2, merge_to_json(id, record)).run();
    for (const PlaneId id : batch.removed_merges) s.no_merge.bind(1, id.value).run();
    for (const Decision& d : batch.decisions) {
      s.decision.bind(1, d.keyframe.value).bind(2, std::int64_t{d.accepted}).bind(3, d.what).bind(4, d.reason).run();
    }
    for (const auto& [name, value] : batch.documents) s.document.bind(1, name).bind(2, value).run();
  }

  void write(const Keyframe& keyframe) {
    statements_->keyframe.bind(1, keyframe.id.value)
        .bind(2, session_.id)
        .bind(3, keyframe.stamp.nanoseconds)
        .bind_blob(4, pose_bytes(keyframe.T_odom_base))
        .bind_blob(5, matrix_bytes(keyframe.covariance))
        .bind_blob(6, directions_bytes(keyframe.degenerate))
        .bind_blob(7, compressed(scans_bytes(keyframe.scans)))
        .run();
    if (!keyframe.cloud) return;
    statements_->cloud.bind(1, keyframe.id.value)
        .bind(2, static_cast<std::int64_t>(keyframe.cloud->size()))
        .bind_blob(3, encode_cloud(*keyframe.cloud))
        .run();
  }

  void write_session() {
    statements_->session.bind(1, session_.id)
        .bind(2, session_.source)
        .bind(3, session_.sensor)
        .bind(4, session_.started.nanoseconds)
        .bind_blob(5, pose_bytes(session_.T_base_lidar))
        .bind(6, session_.frame)
        .bind(7, session_.parameters)
        .bind(8, session_.program)
        .bind(9, session_.localisation)
        .run();
    session_in_transaction_ = true;
  }

  Database database_;
  StoredSession session_;
  std::optional<Statements> statements_;
  bool session_in_transaction_ = false;
  bool session_written_ = false;
};

MapStore::MapStore(const std::string& path, Mode mode, StoredSession session, std::function<void(const std::string&)> failed)
    : path_(path), failed_(std::move(failed)), file_(std::make_unique<File>(path, mode, std::move(session))), thread_([this] { run(); }) {}

MapStore::~MapStore() {
  flush(parting);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void MapStore::write(StoreBatch batch) {
  if (batch.empty()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.push_back(std::move(batch));
  }
  changed_.notify_all();
}

bool MapStore::flush(std::chrono::milliseconds limit) {
  std::unique_lock<std::mutex> lock(mutex_);
  const std::size_t failures = failures_;
  ++asked_;
  changed_.notify_all();
  // A failure since now says that waiting is of no use.
  changed_.wait_for(lock, limit, [this, failures] { return (waiting_.empty() && !busy_) || failures_ > failures; });
  return waiting_.empty() && !busy_;
}

std::size_t MapStore::waiting() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return waiting_.size();
}

std::string MapStore::problem() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return problem_;
}

double MapStore::cpu_seconds() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return cpu_seconds_;
}

void MapStore::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || !waiting_.empty(); });
    if (stop_) return;
    write_waiting(lock);
    if (!problem_.empty()) {
      const std::size_t size = waiting_.size();
      const std::size_t asked = asked_;
      changed_.wait_for(lock, retry, [this, size, asked] { return stop_ || waiting_.size() > size || asked_ != asked; });
    }
  }
}

void MapStore::write_waiting(std::unique_lock<std::mutex>& lock) {
  std::deque<StoreBatch> batches;
  while (!waiting_.empty() && batches.size() < most_batches) {
    batches.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
  }
  busy_ = true;
  lock.unlock();
  std::string problem;
  try {
    file_->write(batches);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const double cpu = thread_cpu_seconds();
  lock.lock();
  busy_ = false;
  cpu_seconds_ = cpu;
  const bool is_new = !problem.empty() && problem != problem_;
  problem_ = problem;
  if (!problem.empty()) {
    ++failures_;
    for (auto batch = batches.rbegin(); batch != batches.rend(); ++batch) waiting_.push_front(std::move(*batch));
  }
  changed_.notify_all();
  if (is_new && failed_) {
    lock.unlock();
    failed_(problem);
    lock.lock();
  }
}

namespace {

// Files that were set aside earlier, by number: `<stem>.before<extension>` is 1, `<stem>.before-N<extension>` N.
std::map<int, std::filesystem::path> set_aside_before(const std::filesystem::path& file) {
  std::map<int, std::filesystem::path> found;
  const std::string stem = file.stem().string() + ".before";
  const std::string extension = file.extension().string();
  std::error_code error;
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.size() < stem.size() + extension.size() || name.rfind(stem, 0) != 0 || entry.path().extension() != extension) continue;
    const std::string rest = name.substr(stem.size(), name.size() - stem.size() - extension.size());
    if (rest.empty()) {
      found[1] = entry.path();
    } else if (rest.size() > 1 && rest.size() < 9 && rest[0] == '-' && rest.find_first_not_of("0123456789", 1) == std::string::npos) {
      found[std::stoi(rest.substr(1))] = entry.path();
    }
  }
  return found;
}

}  // namespace

std::string set_aside(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  const fs::path file(path);
  auto earlier = set_aside_before(file);
  const int number = earlier.empty() ? 1 : earlier.rbegin()->first + 1;
  std::string target =
      (file.parent_path() / file.stem()).string() + ".before" + (number > 1 ? '-' + std::to_string(number) : "") + file.extension().string();
  try {  // The log of a program that was killed goes into the file first.
    Database(path, Access::write).execute("PRAGMA wal_checkpoint(TRUNCATE)");
  } catch (const StoreError&) {  // No map, or one that cannot be written: renamed with what lies beside it.
  }
  for (const char* part : {"-wal", "-shm", ""}) {
    if (!fs::exists(path + part, error)) continue;
    fs::rename(path + part, target + part, error);
    if (error) throw StoreError(path + ": it cannot be renamed to " + target + " (" + error.message() + ")");
  }
  for (; earlier.size() >= most_set_aside; earlier.erase(earlier.begin())) {
    for (const char* part : {"-wal", "-shm", ""}) fs::remove(earlier.begin()->second.string() + part, error);
  }
  return target;
}

void copy_map(const std::string& from, const std::string& to) {
  Database database(from, Access::read);
  check_schema(database);
  Statement copy(database, "VACUUM INTO ?");
  copy.bind(1, to);
  try {
    copy.run();
  } catch (const StoreError& error) {
    throw StoreError(to + ": the map cannot be copied here (" + error.what() + ")");
  }
}

}  // namespace sgraph
