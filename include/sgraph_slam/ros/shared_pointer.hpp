#pragma once

#include <memory>

#include <boost/shared_ptr.hpp>

namespace sgraph {

/// Lets a boost pointer keep what a std pointer owns.
template <class T>
struct StdOwner {
  std::shared_ptr<T> owner;
  void operator()(T*) { owner.reset(); }
};

/// Lets a std pointer keep what a boost pointer owns.
template <class T>
struct BoostOwner {
  boost::shared_ptr<T> owner;
  void operator()(T*) { owner.reset(); }
};

/// The same object as a boost pointer, as roscpp wants it; ownership is shared, nothing is copied. A pointer that came from `to_std` is given back.
template <class T>
boost::shared_ptr<T> to_boost(const std::shared_ptr<T>& pointer) {
  const auto* holder = std::get_deleter<BoostOwner<T>>(pointer);
  if (holder && holder->owner.get() == pointer.get()) return holder->owner;
  return boost::shared_ptr<T>(pointer.get(), StdOwner<T>{pointer});
}

/// The same object as a std pointer, as the core wants it; ownership is shared, nothing is copied. A pointer that came from `to_boost` is given back.
template <class T>
std::shared_ptr<T> to_std(const boost::shared_ptr<T>& pointer) {
  const auto* holder = boost::get_deleter<StdOwner<T>>(pointer);
  if (holder && holder->owner.get() == pointer.get()) return holder->owner;
  return std::shared_ptr<T>(pointer.get(), BoostOwner<T>{pointer});
}

}  // namespace sgraph
