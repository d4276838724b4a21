#pragma once

#include <string>

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

/// A visitor that knows the full name of what it is shown.
class NamedVisitor : public ParamVisitor {
 public:
  void group(const char* name, const char* text, const std::function<void(ParamVisitor&)>& describe) final {
    const std::string outer = prefix_;
    prefix_ += std::string(name) + '.';
    ++depth_;
    enter(name, text);
    describe(*this);
    --depth_;
    prefix_ = outer;
  }

 protected:
  virtual void enter(const char* /*name*/, const char* /*text*/) {}

  [[nodiscard]] std::string full(const char* name) const { return prefix_ + name; }
  /// Full name of the group that is open, without the dot at its end.
  [[nodiscard]] std::string group_name() const { return prefix_.substr(0, prefix_.size() - 1); }
  [[nodiscard]] int depth() const { return depth_; }

 private:
  std::string prefix_;
  int depth_ = 0;
};

/// The shortest text that reads back as the same number.
std::string number_text(double value);

}  // namespace sgraph
