#pragma once

#include <memory>
#include <utility>

namespace sgraph {

/// A value that many hold and nobody changes: a copy costs a pointer. To change it, give it a new value; other holders keep theirs.
template <class T>
class Shared {
 public:
  Shared() = default;
  Shared(T value) : value_(std::make_shared<const T>(std::move(value))) {}

  [[nodiscard]] const T& operator*() const { return value_ ? *value_ : nothing(); }
  const T* operator->() const { return &**this; }

 private:
  static const T& nothing() {
    static const T value{};
    return value;
  }

  std::shared_ptr<const T> value_;  // null: T{}
};

}  // namespace sgraph
