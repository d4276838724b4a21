#include "sgraph_slam/core/store/stored_clouds.hpp"

#include <map>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "database.hpp"
#include "schema.hpp"
#include "sgraph_slam/core/store/cloud_codec.hpp"

namespace sgraph {

class StoredClouds::Implementation {
 public:
  explicit Implementation(std::string path) : path_(std::move(path)) {
    Database database(path_, Access::read);
    check_schema(database);
  }

  void put(KeyframeId id, const CloudPtr& cloud) {
    const std::lock_guard<std::mutex> lock(mutex_);
    own_[id] = cloud;
  }

  CloudPtr get(KeyframeId id) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto own = own_.find(id);
    if (own != own_.end()) return own->second;
    // A connection for each: one that stayed would outlive the writer's with the last snapshot, and leave the file in pieces (-wal, -shm).
    try {
      Database database(path_, Access::read);
      Statement select(database, "SELECT data FROM clouds WHERE keyframe = ?");
      select.bind(1, id.value);
      if (select.step()) return std::make_shared<const Cloud>(decode_cloud(select.blob(0)));
    } catch (const std::runtime_error&) {  // damaged: as if there were none
    }
    return nullptr;
  }

 private:
  std::string path_;
  std::mutex mutex_;
  std::map<KeyframeId, CloudPtr> own_;
};

StoredClouds::StoredClouds(const std::string& path) : implementation_(std::make_unique<Implementation>(path)) {}
StoredClouds::~StoredClouds() = default;
void StoredClouds::put(KeyframeId id, const CloudPtr& cloud) { implementation_->put(id, cloud); }
CloudPtr StoredClouds::get(KeyframeId id) const { return implementation_->get(id); }

}  // namespace sgraph
