#pragma once

#include <stdexcept>

namespace sgraph {

/// What is wrong with a map file, in one line that begins with its name.
class StoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace sgraph
