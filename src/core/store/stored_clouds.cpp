#include "sgraph_slam/core/store/stored_clouds.hpp"

#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "database.hpp"
#include "schema.hpp"
#include "sgraph_slam/core/store/cloud_codec.hpp"

namespace sgraph {

class StoredClouds::Implementation {
 public:
  explicit Implementation(const std::string& path) : database_(path, Access::read) {
    check_schema(database_);
    select_.emplace(database_, "SELECT data FROM clouds WHERE keyframe = ?");
  }

  void put(KeyframeId id, const CloudPtr& cloud) {
    const std::lock_guard<std::mutex> lock(mutex_);
    own_[id] = cloud;
  }

  CloudPtr get(KeyframeId id) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto own = own_.find(id);
    if (own != own_.end()) return own->second;
    CloudPtr cloud;
    try {
      select_->bind(1, id.value);
      if (select_->step()) cloud = std::make_shared<const Cloud>(decode_cloud(select_->blob(0)));
    } catch (const std::runtime_error&) {  // damaged: as if there were none
    }
    select_->reset();
    return cloud;
  }

 private:
  Database database_;
  std::optional<Statement> select_;
  std::mutex mutex_;
  std::map<KeyframeId, CloudPtr> own_;
};

StoredClouds::StoredClouds(const std::string& path) : implementation_(std::make_unique<Implementation>(path)) {}
StoredClouds::~StoredClouds() = default;
void StoredClouds::put(KeyframeId id, const CloudPtr& cloud) { implementation_->put(id, cloud); }
CloudPtr StoredClouds::get(KeyframeId id) const { return implementation_->get(id); }

}  // namespace sgraph
