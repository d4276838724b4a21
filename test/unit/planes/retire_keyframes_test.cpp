#include "sgraph_slam/core/planes/retire_keyframes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/planes/add_observations.hpp"
#include "support/mapped_building.hpp"

namespace sgraph {
namespace {

// A room of 6 x 4 m around the origin, its floor included, in which a robot walks the same 3 m again and again.
class Walks {
 public:
  explicit Walks(int spot_keyframes) : planes_(params(spot_keyframes), {}) {}

  void go(int keyframes) {
    for (int i = 0; i < keyframes; ++i) step();
  }

  int retire() { return static_cast<int>(retire_keyframes(committer_, planes_, {0}, {newest_ - 8}).size()); }

  // Where the robot really is at keyframe k: to and fro along x.
  static Pose truth(std::int64_t k) {
    const double way = std::fmod(0.5 * static_cast<double>(k), 6.0);
    const double x = way < 3 ? way - 1.5 : 4.5 - way;
    return {Eigen::Quaterniond(Eigen::AngleAxisd(0.1 * std::sin(static_cast<double>(k)), Eigen::Vector3d::UnitZ())), {x, 0.02, 0}};
  }

  std::size_t views() const {
    std::size_t count = 0;
    for (const auto& [id, factor] : graph_.factors()) count += is_view(factor.data) ? 1 : 0;
    return count;
  }

  double worst_error() const {
    const Pose T_map_truth = *graph_.find(KeyframeId{0}) * truth(0).inverse();
    double worst = 0;
    for (const auto& [id, pose] : graph_.keyframes())
      worst = std::max(worst, (pose.translation - (T_map_truth * truth(id.value)).translation).norm());
    return worst;
  }

  Graph graph_;
  DecisionLog log_;
  Committer committer_{graph_, log_};
  PlaneLayer planes_;
  bool hatch_ = false;  // whether something stands in the corner

 private:
  static PlaneLayerParams params(int spot_keyframes) {
    PlaneLayerParams params;
    params.factors.spot_keyframes = spot_keyframes;
    return params;
  }

  void step() {
    const KeyframeId id{++newest_};
    Transaction edit;
    if (newest_ == 0) {
      edit.keyframes[id] = truth(0);
    } else {
      // An odometry that reads 2 % too far.
      Pose motion = truth(newest_ - 1).inverse() * truth(newest_);
      motion.translation *= 1.02;
      edit.keyframes[id] = *graph_.find(KeyframeId{newest_ - 1}) * motion;
      add_factor(edit, Se3Between{{newest_ - 1}, id, motion, SqrtInformation<6>::from_std_dev(Vector6::Constant(0.01))});
    }
    ASSERT_TRUE(committer_.commit(edit).ok());
    planes_.drift.add(id, {}, 1e-4 * Matrix6::Identity());
    Keyframe keyframe;
    keyframe.id = id;
    PlaneSegments segments;
    const std::vector<std::pair<Eigen::Vector3d, Eigen::Vector2d>> surfaces{
        {{3, 0, 0}, {4, 2}}, {{-3, 0, 0}, {4, 2}}, {{0, 2, 0}, {6, 2}}, {{0, -2, 0}, {6, 2}}, {{0, 0, -1}, {6, 4}}};
    for (const auto& [middle, size] : surfaces) segments.segments.push_back(seen(middle, size, truth(newest_)));
    if (hatch_) segments.segments.push_back(seen({2, 1.2, -0.3}, {0.8, 0.8}, truth(newest_)));
    const AssociationResult result = add_observations(committer_, planes_, keyframe, segments);
    EXPECT_EQ(result.seen.size(), segments.segments.size());
    EXPECT_EQ(result.created, newest_ == 0 ? 5 : hatch_ ? 1 : 0);
    solve(graph_, {}, recent_window(graph_, 8));
  }

  // A surface whose nearest point to the origin is `middle`, from a pose.
  PlaneSegment seen(const Eigen::Vector3d& middle, const Eigen::Vector2d& size, const Pose& from) {
    const Eigen::Vector3d u = std::abs(middle.z()) > 0.5 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(-middle.y(), middle.x(), 0).normalized();
    const Eigen::Vector3d v = middle.normalized().cross(u);
    std::normal_distribution<double> noise(0, 0.003);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i <= 20; ++i) {
      for (int k = 0; k <= 8; ++k)
        points.push_back(from.inverse() * Eigen::Vector3d(middle + (i / 20.0 - 0.5) * size.x() * u + (k / 8.0 - 0.5) * size.y() * v +
                                                          noise(random_) * middle.normalized()));
    }
    return fit_segment(points, 0.02);
  }

  std::int64_t newest_ = -1;
  std::mt19937 random_{7};
};

TEST(RetireKeyframes, GraphGrowsWithTheSpotsAndNotWithTheVisits) {
  Walks walks(4);
  std::vector<std::size_t> views;
  for (int lap = 0; lap < 6; ++lap) {
    walks.go(24);
    walks.retire();
    views.push_back(walks.views());
    // The plane map has the graph's views, no others.
    std::size_t noted = 0;
    for (const auto& [id, record] : walks.planes_.map.records()) {
      for (const PlaneObservation& seen : record.observations) EXPECT_NE(walks.graph_.find(seen.factor), nullptr);
      noted += record.observations.size();
    }
    EXPECT_EQ(noted, views.back());
  }
  EXPECT_LE(views.back(), views[3] + 5U);
  EXPECT_LT(views.back(), 6U * 24U * 5U / 2U);
  solve(walks.graph_, {});
  EXPECT_LT(walks.worst_error(), 0.006);
}

TEST(RetireKeyframes, LosesNothingThatCounts) {
  Walks all(0);
  Walks fewer(4);
  for (Walks* walks : {&all, &fewer}) {
    for (int lap = 0; lap < 4; ++lap) {
      walks->go(24);
      solve(walks->graph_, {});
      walks->retire();
    }
    solve(walks->graph_, {});
  }
  EXPECT_LT(fewer.views(), all.views() / 2);
  EXPECT_EQ(all.views(), 5U * 96U);
  EXPECT_LT(fewer.worst_error(), all.worst_error() + 0.002);
}

// The pose of a keyframe that is retired moves with the one that it stood beside, and pulls at nothing.
TEST(RetireKeyframes, KeepTheirPlaceAndPullAtNothing) {
  Walks walks(1);
  walks.go(40);
  solve(walks.graph_, {});
  Graph before = walks.graph_;
  const std::map<PlaneId, PlaneRecord> records = walks.planes_.map.records();
  const int count = walks.retire();
  EXPECT_GT(count, 10);
  EXPECT_EQ(walks.retire(), 0);  // each is asked once
  int retired = 0;
  int odometry = 0;
  for (const auto& [id, factor] : walks.graph_.factors()) {
    const auto* between = std::get_if<Se3Between>(&factor.data);
    if (between == nullptr) continue;
    if (between->source != Se3Between::Source::retired) {
      ++odometry;
      continue;
    }
    ++retired;
    EXPECT_LT(between->from, between->to);
    EXPECT_LT(between->to.value, 31);  // the newest stay
    EXPECT_EQ(walks.graph_.factors_of(between->to).size(), 1U);
    EXPECT_LT(chi_square(walks.graph_, factor.data), 1e-12);
  }
  EXPECT_EQ(retired, count);
  EXPECT_EQ(odometry, 39 - count);  // one past each
  for (const auto& [id, pose] : before.keyframes()) EXPECT_EQ(pose.translation, walks.graph_.find(id)->translation);
  for (const auto& [id, record] : walks.planes_.map.records()) EXPECT_EQ(record.last_seen, records.at(id).last_seen);
  solve(walks.graph_, {});
  for (const auto& [id, pose] : before.keyframes()) EXPECT_LT((pose.translation - walks.graph_.find(id)->translation).norm(), 0.004);
}

// The newest show what has been moved since.
TEST(RetireKeyframes, CloudsAreBoundedByTheSpotsToo) {
  Walks walks(2);
  std::set<KeyframeId> with_clouds;
  std::set<KeyframeId> gone;
  std::size_t after_fifty = 0;
  for (int k = 0; k < 20; ++k) {
    walks.go(10);
    const std::vector<KeyframeId> newly = retire_keyframes(walks.committer_, walks.planes_, {0}, {10 * k + 2});
    for (const KeyframeId id : clouds_to_let_go(walks.graph_, with_clouds, newly)) EXPECT_TRUE(gone.insert(id).second) << id.value;
    if (k == 5) after_fifty = with_clouds.size();
  }
  EXPECT_GT(gone.size(), 100U);
  EXPECT_LE(with_clouds.size(), after_fifty + 5);
  for (const KeyframeId id : with_clouds) EXPECT_EQ(gone.count(id), 0U);
  // Of each spot's, the newest are there.
  for (const KeyframeId id : gone) {
    int newer = 0;
    for (const KeyframeId other : with_clouds)
      newer += id < other && (walks.graph_.find(id)->translation - walks.graph_.find(other)->translation).norm() < 1.0 ? 1 : 0;
    EXPECT_GE(newer, 4) << id.value;
  }
}

// What the others didn't show goes to the one beside it, measured as that one would have.
TEST(RetireKeyframes, NothingSeenOnlyOnceIsLost) {
  for (const char* form : {"tangent", "points"}) {
    Walks walks(2);
    walks.planes_.params.factors.plane_factor = form;
    walks.go(24);
    walks.hatch_ = true;
    walks.go(1);  // something in the corner is there for a moment
    walks.hatch_ = false;
    walks.go(24);
    solve(walks.graph_, {});
    const Graph before = walks.graph_;
    const Eigen::Vector3d center = outline_center(walks.planes_.map.find({5})->outline);
    walks.retire();
    const PlaneRecord* record = walks.planes_.map.find({5});
    ASSERT_NE(record, nullptr);
    ASSERT_EQ(record->observations.size(), 1U);
    const PlaneObservation& seen = record->observations.front();
    EXPECT_LT(seen.keyframe.value, 24);
    EXPECT_EQ(record->last_seen.value, 24);
    const FactorData& now = walks.graph_.find(seen.factor)->data;
    EXPECT_LT(chi_square(walks.graph_, now), 1e-3 + chi_square(before, before.find(*before.factors_of(PlaneId{5}).begin())->data));
    EXPECT_STREQ(type_name(now), std::string(form) == "points" ? "pose_plane_points" : "pose_plane");
    walks.planes_.map.refresh(walks.graph_, walks.planes_.frame);
    EXPECT_LT((outline_center(walks.planes_.map.find({5})->outline) - center).norm(), 0.02);
  }
}

}  // namespace
}  // namespace sgraph
