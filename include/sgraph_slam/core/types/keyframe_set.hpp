#pragma once

#include <algorithm>
#include <initializer_list>
#include <vector>

#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// Keyframes in order, each once: eight bytes a keyframe and quick to copy, since every snapshot holds one for each plane.
class KeyframeSet {
 public:
  using const_iterator = std::vector<KeyframeId>::const_iterator;

  KeyframeSet() = default;
  KeyframeSet(std::initializer_list<KeyframeId> ids) {
    for (const KeyframeId id : ids) insert(id);
  }

  void insert(KeyframeId id) {
    if (ids_.empty() || ids_.back() < id) return ids_.push_back(id);  // they come in order
    const auto at = std::lower_bound(ids_.begin(), ids_.end(), id);
    if (*at != id) ids_.insert(at, id);
  }
  void clear() { ids_.clear(); }

  [[nodiscard]] std::size_t count(KeyframeId id) const { return std::binary_search(ids_.begin(), ids_.end(), id) ? 1 : 0; }
  [[nodiscard]] std::size_t size() const { return ids_.size(); }
  [[nodiscard]] bool empty() const { return ids_.empty(); }
  [[nodiscard]] const_iterator begin() const { return ids_.begin(); }
  [[nodiscard]] const_iterator end() const { return ids_.end(); }
  /// The newest; not to be asked of an empty set.
  [[nodiscard]] KeyframeId newest() const { return ids_.back(); }

  friend bool operator==(const KeyframeSet& a, const KeyframeSet& b) { return a.ids_ == b.ids_; }
  friend bool operator!=(const KeyframeSet& a, const KeyframeSet& b) { return !(a == b); }

 private:
  std::vector<KeyframeId> ids_;
};

}  // namespace sgraph
