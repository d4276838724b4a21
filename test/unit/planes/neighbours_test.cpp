// What is searched for near something is the same as when all are asked.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/planes/ground_path.hpp"
#include "sgraph_slam/core/planes/merging.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {
namespace {

class Random {
 public:
  explicit Random(unsigned seed) : random_(seed) {}
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Eigen::Vector3d in_box(double x, double y, double z) { return {(*this)(-x, x), (*this)(-y, y), (*this)(0, z)}; }

 private:
  std::mt19937 random_;
};

TEST(PlaneIndex, FindsWhatAskingAllFinds) {
  Random random(1);
  std::map<PlaneId, Eigen::AlignedBox3d> boxes;
  PlaneIndex index;
  const auto draw = [&random] {
    const Eigen::Vector3d center = random.in_box(60, 40, 3);
    Eigen::AlignedBox3d box(center, center);
    box.extend(center + random.in_box(random(0, 1) < 0.1 ? 50 : 4, random(0, 1) < 0.1 ? 50 : 4, 2));
    return box;
  };
  for (int step = 0; step < 3000; ++step) {
    const PlaneId id{static_cast<std::int64_t>(random(0, 300))};
    const double dice = random(0, 1);
    if (dice < 0.2) {
      boxes.erase(id);
      index.erase(id);
    } else {
      index.put(id, boxes[id] = draw());
    }
    const Eigen::AlignedBox3d asked = draw();
    const double gap = random(0, 1) < 0.05 ? 300 : random(0, 3);
    std::vector<PlaneId> expected;
    for (const auto& [other, box] : boxes) {
      if (box.exteriorDistance(asked) <= gap) expected.push_back(other);
    }
    ASSERT_EQ(index.near(asked, gap), expected) << step;
  }
  EXPECT_TRUE(index.near({}, 5).empty());
}

TEST(GroundPath, MissesNoStepThatCrossesALine) {
  Random random(2);
  std::vector<Eigen::Vector2d> points{{0, 0}};
  for (int i = 0; i < 400; ++i) points.push_back(points.back() + Eigen::Vector2d(random(-1, 1.1), random(-1, 1.1)) * (i % 50 == 0 ? 20 : 1));
  const GroundPath path(points);
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::Vector2d a(random(-30, 60), random(-30, 60));
    const Eigen::Vector2d b = a + Eigen::Vector2d(random(-1, 1), random(-1, 1)) * (trial % 10 == 0 ? 60 : 6);
    const std::vector<std::size_t> near = path.steps_near(a, b);
    EXPECT_TRUE(std::is_sorted(near.begin(), near.end()));
    const auto side = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& r) {
      return (q - p).x() * (r - p).y() - (q - p).y() * (r - p).x();
    };
    for (std::size_t i = 1; i < points.size(); ++i) {
      const bool crosses =
          side(a, b, points[i - 1]) * side(a, b, points[i]) <= 0 && side(points[i - 1], points[i], a) * side(points[i - 1], points[i], b) <= 0;
      EXPECT_TRUE(!crosses || std::binary_search(near.begin(), near.end(), i)) << trial << " " << i;
    }
  }
}

// Walls of a building with drift: many alike, some seen twice.
struct Walls {
  Graph graph;
  PlaneMap planes{{}};

  explicit Walls(unsigned seed) {
    Random random(seed);
    Transaction edit;
    for (int k = 0; k < 20; ++k) edit.keyframes[KeyframeId{k}] = Pose{so3_exp({0, 0, random(-3, 3)}), random.in_box(20, 15, 0)};
    for (int p = 0; p < 120; ++p) {
      const double yaw = M_PI / 2 * static_cast<int>(random(0, 4)) + random(-0.05, 0.05);
      const Eigen::Vector3d normal(std::cos(yaw), std::sin(yaw), 0);
      edit.planes[PlaneId{p}] = {normal, -normal.dot(random.in_box(20, 15, 0))};
    }
    EXPECT_TRUE(graph.apply(edit).ok());
    for (const auto& [id, plane] : graph.planes()) {
      const int views = 1 + static_cast<int>(random(0, 3));
      for (int i = 0; i < views; ++i) {
        const KeyframeId keyframe{static_cast<std::int64_t>(random(0, 20))};
        const Pose T_base_map = graph.find(keyframe)->inverse();
        const Eigen::Vector3d along(-plane.normal.y(), plane.normal.x(), 0);
        const Eigen::Vector3d center = -plane.d * plane.normal + random(-20, 20) * along;
        const double half = random(0.5, 4);
        const Outline outline{T_base_map * (center - half * along), T_base_map * (center + half * along),
                              T_base_map * (center + half * along + Eigen::Vector3d(0, 0, 2.5)),
                              T_base_map * (center - half * along + Eigen::Vector3d(0, 0, 2.5))};
        planes.observe(graph, id, keyframe, {0}, outline, {}, T_base_map * plane, Eigen::Matrix3d::Identity() * 1e-4);
      }
    }
  }
};

TEST(MergeCandidates, AreThoseThatAskingAllPairsFinds) {
  const MergeParams params;
  const double margin = 1.2;
  std::size_t found = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Walls walls(seed);
    std::set<PlanePair> expected;  // by what must hold of a pair, weakened so that it needs no common point
    for (const auto& [a, record_a] : walls.planes.records()) {
      for (const auto& [b, record_b] : walls.planes.records()) {
        const Plane& plane_a = *walls.graph.find(a);
        const Plane& plane_b = *walls.graph.find(b);
        if (!(a < b) || plane_a.normal.dot(plane_b.normal) < std::cos(params.max_angle)) continue;
        const double wa = outline_area(record_a.outline);
        const double wb = outline_area(record_b.outline);
        const Eigen::Vector3d point = (wb * outline_center(record_a.outline) + wa * outline_center(record_b.outline)) / (wa + wb);
        if (std::abs(plane_b.distance(point) - plane_a.distance(point)) > params.max_distance) continue;
        if (outline_distance(plane_a, record_a.outline, record_b.outline) <= margin) expected.insert({a, b});
      }
    }
    const std::vector<PlanePair> pairs = merge_candidates(walls.graph, walls.planes, params, margin);
    EXPECT_EQ(std::set<PlanePair>(pairs.begin(), pairs.end()), expected) << seed;
    EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
    found += pairs.size();
  }
  EXPECT_GT(found, 20U);
}

double off(const Outline& a, const Outline& b, const Plane& plane) {
  double most = 0;
  for (const Eigen::Vector3d& p : a) most = std::max(most, outline_distance(plane, {p}, b));
  return most;
}

// Extents are put together anew when something moved by more than the tolerance; what is kept is within it of what that would give.
TEST(PlaneMap, RefreshedExtentsAreWithinTheToleranceOfThoseMadeAnew) {
  for (const double size : {1e-5, 1e-4, 5e-4, 2e-3, 2e-2}) {
    Random random(7);
    Walls walls(3);
    walls.planes.refresh(walls.graph, {});
    for (int round = 0; round < 5; ++round) {
      for (const auto& [id, pose] : walls.graph.keyframes()) {
        const Eigen::Vector3d turn(random(-1, 1), random(-1, 1), random(-1, 1));
        walls.graph.set(id, pose * Pose{so3_exp(0.1 * size * turn), size * Eigen::Vector3d(random(-1, 1), random(-1, 1), random(-1, 1))});
      }
      for (const auto& [id, plane] : walls.graph.planes())
        walls.graph.set(id, Plane{so3_exp(0.1 * size * Eigen::Vector3d(random(-1, 1), random(-1, 1), random(-1, 1))) * plane.normal,
                                  plane.d + size * random(-1, 1)});
      walls.planes.refresh(walls.graph, {});
      for (const auto& [id, record] : walls.planes.records()) {
        PlaneMap anew{{}};
        const Plane& plane = *walls.graph.find(id);
        for (const PlaneObservation& seen : record.observations)
          anew.observe(walls.graph, id, seen.keyframe, seen.factor, seen.outline_base, {}, walls.graph.find(seen.keyframe)->inverse() * plane,
                       Eigen::Matrix3d::Identity());
        anew.refresh(walls.graph, {});
        const PlaneRecord& made = *anew.find(id);
        EXPECT_LT(off(record.outline, made.outline, plane), 4 * PlaneMap::tolerance) << size;
        EXPECT_LT(off(made.outline, record.outline, plane), 4 * PlaneMap::tolerance) << size;
        ASSERT_EQ(record.wall.has_value(), made.wall.has_value());
        if (!record.wall) continue;
        EXPECT_NEAR(record.wall->offset, made.wall->offset, 1e-3);
        EXPECT_LT((record.wall->normal - made.wall->normal).norm(), 1e-12);  // the walls always follow their planes
        ASSERT_EQ(record.wall->support.size(), made.wall->support.size());
        for (std::size_t i = 0; i < made.wall->support.size(); ++i) {
          EXPECT_NEAR(record.wall->support[i].low, made.wall->support[i].low, 4 * PlaneMap::tolerance);
          EXPECT_NEAR(record.wall->support[i].high, made.wall->support[i].high, 4 * PlaneMap::tolerance);
        }
      }
    }
  }
}

}  // namespace
}  // namespace sgraph
