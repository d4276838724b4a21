#pragma once

#include <functional>
#include <string>
#include <vector>

namespace sgraph {

struct Range {
  double low;
  double high;
};

/// Goes through the parameters of a struct. Each parameter struct declares its fields once, with their defaults, and has
/// `void describe(ParamVisitor& v)` that names each with its unit, range and a sentence; readers, validator, printer and the documentation's
/// table are visitors.
class ParamVisitor {
 public:
  virtual ~ParamVisitor() = default;

  virtual void field(const char* name, double& value, const char* unit, Range range, const char* text) = 0;
  virtual void field(const char* name, int& value, const char* unit, Range range, const char* text) = 0;
  virtual void field(const char* name, bool& value, const char* text) = 0;
  /// Free text.
  virtual void field(const char* name, std::string& value, const char* text) = 0;
  /// One of several words.
  virtual void choice(const char* name, std::string& value, const std::vector<std::string>& options, const char* text) = 0;

  /// Fields described within `describe` are named `name.field`.
  virtual void group(const char* name, const char* text, const std::function<void(ParamVisitor&)>& describe) = 0;

  template <class Params>
  void group(const char* name, Params& params, const char* text) {
    group(name, text, [&params](ParamVisitor& v) { params.describe(v); });
  }
};

}  // namespace sgraph
