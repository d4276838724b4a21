#include "sgraph_slam/core/util/rng.hpp"

#include <cmath>

namespace sgraph {

namespace {

constexpr std::uint64_t golden = 0x9E3779B97F4A7C15ULL;

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31U);
}

double open_unit(std::uint64_t bits) { return (static_cast<double>(bits >> 11U) + 0.5) * 0x1.0p-53; }

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t stream) : origin_(mix(mix(seed + golden) + (stream + 1) * golden)) {}

std::uint64_t RandomStream::bits(std::uint64_t index) const { return mix(origin_ + (index + 1) * golden); }

double RandomStream::uniform(std::uint64_t index) const { return open_unit(bits(index)); }

double RandomStream::normal(std::uint64_t index) const {
  const std::uint64_t first = bits(index);
  return std::sqrt(-2.0 * std::log(open_unit(first))) * std::cos(2.0 * M_PI * open_unit(mix(first ^ golden)));
}

}  // namespace sgraph
