#pragma once

#include <cstdint>
#include <limits>
#include <stdexcept>

namespace sgraph {

/// The integer that a JSON value holds. Throws std::runtime_error for anything else: a library's own conversion takes 3e14 for an int, and the result
/// is undefined.
template <class Json>
std::int64_t integer_from(const Json& json) {
  const bool too_large =
      json.is_number_unsigned() && json.template get<std::uint64_t>() > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (!json.is_number_integer() || too_large) throw std::runtime_error("an integer is wanted in place of " + json.dump());
  return json.template get<std::int64_t>();
}

}  // namespace sgraph
