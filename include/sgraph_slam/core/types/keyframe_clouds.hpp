#pragma once

#include <memory>
#include <utility>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// Where the clouds of keyframes are while nobody works on them: a file, a database. Memory is then bounded by what is being worked on. All functions
/// may be called from any thread.
class KeyframeClouds {
 public:
  virtual ~KeyframeClouds() = default;

  /// Keeps the cloud of a keyframe, points in the LiDAR's frame; replaces one put earlier; null: lets that go.
  /// Never loses it: where it can't be written (no space left) it stays in memory, and whoever owns the store reports that.
  virtual void put(KeyframeId id, const CloudPtr& cloud) = 0;

  /// The cloud as it was put, viewpoints included; null when there is none, or when it can't be read any more.
  [[nodiscard]] virtual CloudPtr get(KeyframeId id) const = 0;
};

/// A keyframe's cloud, wherever it is: in memory, or in a store that it is read back from when somebody asks. Copies cost nothing.
class KeyframeCloud {
 public:
  KeyframeCloud() = default;
  /// In memory.
  KeyframeCloud(CloudPtr cloud) : cloud_(std::move(cloud)) {}
  KeyframeCloud(const std::shared_ptr<Cloud>& cloud) : cloud_(cloud) {}
  KeyframeCloud(std::nullptr_t) {}
  /// In a store, put there as `id`.
  KeyframeCloud(std::shared_ptr<const KeyframeClouds> store, KeyframeId id) : store_(std::move(store)), id_(id) {}

  /// Whether the keyframe has a cloud.
  explicit operator bool() const { return cloud_ != nullptr || store_ != nullptr; }

  /// The cloud; null when there is none, or when the store can't give it back. Any thread.
  [[nodiscard]] CloudPtr get() const { return store_ ? store_->get(id_) : cloud_; }

 private:
  CloudPtr cloud_;
  std::shared_ptr<const KeyframeClouds> store_;
  KeyframeId id_;
};

}  // namespace sgraph
