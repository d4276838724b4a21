#pragma once

#include <memory>
#include <string>

#include "sgraph_slam/core/types/keyframe_clouds.hpp"

namespace sgraph {

/// The clouds of a map file, read when somebody asks for one. Any thread.
class StoredClouds : public KeyframeClouds {
 public:
  /// Throws StoreError when the file cannot be read.
  explicit StoredClouds(const std::string& path);
  ~StoredClouds() override;

  /// Kept in memory: this class does not write files.
  void put(KeyframeId id, const CloudPtr& cloud) override;
  [[nodiscard]] CloudPtr get(KeyframeId id) const override;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sgraph
