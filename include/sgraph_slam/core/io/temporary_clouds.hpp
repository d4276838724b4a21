#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <string>

#include "sgraph_slam/core/types/keyframe_clouds.hpp"

namespace sgraph {

/// Keyframe clouds in a file that has no name: it is gone with the process, however that ends. The clouds used last stay in memory too.
class TemporaryClouds : public KeyframeClouds {
 public:
  /// `folder`: where the file is made; empty: the system's folder for temporary files. `cached`: clouds kept in memory. When no file can be made
  /// there, all clouds stay in memory and failure() says why.
  explicit TemporaryClouds(const std::string& folder = {}, std::size_t cached = 12);
  ~TemporaryClouds() override;
  TemporaryClouds(const TemporaryClouds&) = delete;
  TemporaryClouds& operator=(const TemporaryClouds&) = delete;

  void put(KeyframeId id, const CloudPtr& cloud) override;
  [[nodiscard]] CloudPtr get(KeyframeId id) const override;

  /// Why clouds stay in memory: the system's reason; empty while all is well.
  [[nodiscard]] std::string failure() const;
  /// Clouds in memory: the newest used, and those that couldn't be written.
  [[nodiscard]] std::size_t in_memory() const;

 private:
  struct Place {
    std::int64_t offset = 0;
    std::size_t bytes = 0;
  };

  void remember(KeyframeId id, const CloudPtr& cloud) const;

  const std::size_t cached_;
  int file_ = -1;
  mutable std::mutex mutex_;  // guards what follows
  std::string failure_;
  std::int64_t end_ = 0;
  std::map<KeyframeId, Place> places_;
  std::map<KeyframeId, CloudPtr> unwritten_;
  mutable std::list<std::pair<KeyframeId, CloudPtr>> newest_;  // the last used first
};

}  // namespace sgraph
