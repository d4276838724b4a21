// A step of the mapping that fails half-way, at whatever point: memory runs out at the n-th allocation, for growing n.

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "support/mapping_run.hpp"

namespace {
thread_local long until_failure = -1;  // allocations on this thread; below zero: none fails
}

// All that allocate without an alignment of their own, and all that free it again: a sanitizer refuses memory that one library allocates and another
// frees.
void* operator new(std::size_t size) {
  if (until_failure >= 0 && until_failure-- == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new(std::size_t size, const std::nothrow_t& /*unused*/) noexcept {
  try {
    return operator new(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void* operator new[](std::size_t size, const std::nothrow_t& /*unused*/) noexcept { return operator new(size, std::nothrow); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t& /*unused*/) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t& /*unused*/) noexcept { std::free(memory); }

namespace sgraph {
namespace {

std::vector<SeenKeyframe> short_walk() {
  MappedBuilding building;
  building.add_room(0, 0, 6, 5, {{}, {{2, 3}}, {}, {}});
  building.add_room(6.15, 0, 12, 5, {{}, {}, {}, {{2, 3}}});
  return building.walk({{1, 1}, {4, 1}, {4, 2.5}, {9, 2.5}, {9, 4}, {7, 2.5}, {3, 2.5}, {1, 1}}, 0.8, 0.2, {}, 4);
}

struct Ending {
  GraphSnapshotPtr map;
  std::vector<std::string> failures;
  bool failed = false;  // whether the memory ran out before the step was over
};

// The walk mapped; at its keyframe `broken` the allocation `n` fails.
Ending map_with_failure(const std::vector<SeenKeyframe>& walk, std::size_t broken, long n) {
  BackEnd back_end({}, MappedBuilding::T_base_lidar());
  Ending ending;
  for (std::size_t k = 0; k < walk.size(); ++k) {
    if (k == broken) until_failure = n;
    back_end.process(walk[k].keyframe, walk[k].segments);
    if (k == broken) ending.failed = until_failure < 0;
    until_failure = -1;
  }
  ending.failures = back_end.failures();
  ending.map = back_end.optimize();
  return ending;
}

void expect_same(const GraphSnapshot& a, const GraphSnapshot& b) {
  EXPECT_EQ(a.factors_json, b.factors_json);
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (const auto& [id, keyframe] : a.keyframes) {
    EXPECT_EQ(keyframe.T_map_base.translation, b.keyframes.at(id).T_map_base.translation) << id.value;
    EXPECT_EQ(keyframe.T_map_base.rotation.coeffs(), b.keyframes.at(id).T_map_base.rotation.coeffs()) << id.value;
  }
  ASSERT_EQ(a.planes.size(), b.planes.size());
  for (const auto& [id, plane] : a.planes) {
    EXPECT_EQ(plane.keyframes, b.planes.at(id).keyframes);
    EXPECT_EQ(plane.extent, b.planes.at(id).extent);
  }
  EXPECT_EQ(a.rooms.size(), b.rooms.size());
  EXPECT_EQ(a.corridors.size(), b.corridors.size());
}

// Wherever it fails, the map is in the end the same: that of the keyframes before, this one's motion, and what came after.
TEST(FailedStep, IsUndoneAtWhateverPointItFails) {
  const auto walk = short_walk();
  ASSERT_GT(walk.size(), 24U);
  const Ending sound = map_with_failure(walk, walk.size(), 0);
  EXPECT_TRUE(sound.failures.empty());
  for (const std::size_t broken : {std::size_t{13}, std::size_t{19}}) {
    std::optional<Ending> reference;
    int failures = 0;
    for (long n = 200; n < 100'000'000; n *= 2) {
      const Ending ending = map_with_failure(walk, broken, n);
      if (!ending.failed) break;
      ++failures;
      if (ending.failures.empty()) {  // it hit the copy of the last good state, of which an older one is kept: nothing is lost
        expect_same(*sound.map, *ending.map);
        continue;
      }
      ASSERT_EQ(ending.failures.size(), 1U) << n;
      EXPECT_NE(ending.failures.front().find("keyframe/" + std::to_string(broken)), std::string::npos) << ending.failures.front();
      EXPECT_EQ(ending.map->keyframes.size(), walk.size());
      EXPECT_LT(ending.map->factors_json.size(), sound.map->factors_json.size());  // its planes are missing
      if (!reference) {
        reference = ending;
      } else {
        expect_same(*reference->map, *ending.map);
      }
    }
    EXPECT_GE(failures, 3);
  }
}

// The very first one: back to the empty map.
TEST(FailedStep, TheFirstKeyframeToo) {
  const auto walk = short_walk();
  const Ending ending = map_with_failure(walk, 0, 300);
  ASSERT_TRUE(ending.failed);
  EXPECT_EQ(ending.failures.size(), 1U);
  EXPECT_EQ(ending.map->keyframes.size(), walk.size());
  EXPECT_GT(ending.map->planes.size(), 5U);
}

}  // namespace
}  // namespace sgraph
