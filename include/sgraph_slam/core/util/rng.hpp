#pragma once

#include <cstdint>

namespace sgraph {

/// A stream of random numbers that is a function of (seed, stream, index) alone: the n-th number can be asked for without the ones before it, so
/// neither the order of the calls nor another stream's use changes it. Same numbers on every machine with IEEE doubles; no distribution of the
/// standard library is involved (those differ between libraries). SplitMix64 (Steele et al. 2014) over a hashed origin.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream);

  [[nodiscard]] std::uint64_t bits(std::uint64_t index) const;
  /// In the open interval (0, 1).
  [[nodiscard]] double uniform(std::uint64_t index) const;
  /// Standard normal (Box-Muller).
  [[nodiscard]] double normal(std::uint64_t index) const;

  /// The same, counting up from index 0.
  double next_uniform() { return uniform(next_++); }
  double next_normal() { return normal(next_++); }

 private:
  std::uint64_t origin_;
  std::uint64_t next_ = 0;
};

}  // namespace sgraph
