#include "sgraph_slam/core/pipeline/variants.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/io/map_folder.hpp"
#include "sgraph_slam/core/pipeline/pipeline.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph {
namespace {

using testing::HasSubstr;

Variant variant(const std::string& text) { return parse_variant(text, {}); }

double sum(const StageTimes& times) { return std::accumulate(times.begin(), times.end(), 0.0); }

// The first seconds of a walk in an empty hall.
sim::SimulatedSource hall(double duration) {
  const sim::World world = sim::box_world(9, 6, 2.8, {{-3, -1}, {2.5, -1}, {2.5, 1.5}});
  sim::SimulationSettings settings;
  settings.duration = duration;
  return {world, settings};
}

// The variants over the same recording, together.
std::unique_ptr<VariantSet> mapped(std::vector<Variant> variants, double duration = 4) {
  sim::SimulatedSource source = hall(duration);
  auto set = std::make_unique<VariantSet>(std::move(variants), source.T_base_lidar());
  while (const auto event = source.next()) {
    if (const auto* odometry = std::get_if<OdometrySample>(&*event)) set->add(*odometry);
    if (const auto* imu = std::get_if<ImuSample>(&*event)) set->add(*imu);
    if (const auto* scan = std::get_if<CloudPtr>(&*event)) set->process(**scan);
  }
  set->finish();
  return set;
}

std::string outcome(const Run& run) { return graph_json(*run.snapshot()) + tum_text(run.trajectory()) + tum_text(run.live_trajectory()); }

TEST(Variants, TogetherEachGivesWhatItGivesAlone) {
  const std::vector<Variant> variants{variant("full"),
                                      variant("no_layer:mapping.topological_layer=false"),
                                      variant("encoders:odometry.source=topic"),
                                      variant("coarse:odometry.map.voxel=0.5,odometry.keyframe.cloud=scan"),
                                      variant("large_planes:segmentation.min_area=4"),
                                      variant("odometry:until=odometry")};
  const auto together = mapped(variants);
  EXPECT_EQ(together->front_ends(), 3U);  // the LiDAR's, the encoders', the coarse one
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const auto alone = mapped({variants[i]});
    EXPECT_EQ(outcome(together->runs()[i]), outcome(alone->runs().front())) << variants[i].name;
    for (std::size_t k = 0; k < i; ++k) EXPECT_NE(outcome(together->runs()[i]), outcome(together->runs()[k])) << variants[i].name << variants[k].name;
  }
}

TEST(Variants, OneAloneIsThePipeline) {
  const auto set = mapped({variant("full")});
  sim::SimulatedSource source = hall(4);
  Pipeline pipeline(Params(), source.T_base_lidar());
  while (const auto event = source.next()) {
    if (const auto* scan = std::get_if<CloudPtr>(&*event)) pipeline.process(**scan);
  }
  pipeline.finish();
  EXPECT_EQ(outcome(set->runs().front()), outcome(pipeline.run()));
  EXPECT_GE(pipeline.run().snapshot()->planes.size(), 5U);
}

TEST(Variants, ASharedStageIsChargedToAll) {
  const auto set = mapped({variant("full"), variant("no_layer:mapping.topological_layer=false"), variant("odometry:until=odometry")});
  ASSERT_EQ(set->front_ends(), 1U);
  const auto at = [&set](std::size_t run, Stage stage) { return set->runs()[run].total_cost().cpu[static_cast<std::size_t>(stage)]; };
  for (const std::size_t run : {1U, 2U}) {
    EXPECT_EQ(at(run, Stage::prefilter), at(0, Stage::prefilter));
    EXPECT_EQ(at(run, Stage::odometry), at(0, Stage::odometry));
  }
  EXPECT_GT(at(0, Stage::odometry), 0);
  EXPECT_GT(at(0, Stage::segmentation), 0);
  EXPECT_EQ(at(1, Stage::segmentation), at(0, Stage::segmentation));
  EXPECT_EQ(at(2, Stage::segmentation), 0);
  EXPECT_GT(at(1, Stage::mapping), 0);
  EXPECT_EQ(at(2, Stage::mapping), 0);
  EXPECT_LT(sum(set->runs()[2].total_cost().cpu), sum(set->runs()[0].total_cost().cpu));
}

TEST(Variants, StopWhereTheyAreTold) {
  const auto set = mapped({variant("prefilter:until=prefilter"), variant("odometry:until=odometry"), variant("planes:until=segmentation")}, 2);
  EXPECT_EQ(set->front_ends(), 2U);
  EXPECT_TRUE(set->runs()[0].live_trajectory().empty());
  EXPECT_EQ(set->runs()[0].records().size(), 20U);
  EXPECT_EQ(set->runs()[1].live_trajectory().size(), 20U);
  int segments = 0;
  for (const ScanRecord& record : set->runs()[2].records()) segments += record.segments;
  EXPECT_GE(segments, 5);
  EXPECT_TRUE(set->runs()[2].solves().empty());
}

TEST(Variants, AreReadFromText) {
  const Variant v = parse_variant("a_b-2:prefilter.leaf=0.3,until=segmentation,imu=true,odometry.source=topic", {{"prefilter.leaf", "0.2"}});
  EXPECT_EQ(v.name, "a_b-2");
  EXPECT_EQ(v.params.prefilter.leaf, 0.3);
  EXPECT_EQ(v.until, Stage::segmentation);
  EXPECT_TRUE(v.imu);
  EXPECT_TRUE(v.encoders);
  EXPECT_FALSE(variant("x:odometry.source=topic,encoders=false").encoders);
  EXPECT_EQ(parse_variant("plain", {{"prefilter.leaf", "0.2"}}).params.prefilter.leaf, 0.2);
}

TEST(Variants, AWrongOneIsRefusedByName) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      variant(text);
    } catch (const ParamError& error) {
      return error.what();
    }
    return "taken";
  };
  EXPECT_THAT(message("x:prefilter.leav=0.3"), testing::AllOf(HasSubstr("variant x"), HasSubstr("prefilter.leaf")));
  EXPECT_THAT(message("x:until=lunch"), HasSubstr("lunch"));
  EXPECT_THAT(message("x:imu=perhaps"), HasSubstr("perhaps"));
  EXPECT_THAT(message("x:prefilter.leaf"), HasSubstr("variant x"));
  EXPECT_THAT(message("x:"), HasSubstr("variant x"));
  EXPECT_THAT(message("../x"), HasSubstr("letters"));
  EXPECT_THAT(message(""), HasSubstr("letters"));
  EXPECT_THROW(VariantSet({variant("x"), variant("x:until=odometry")}, Pose()), std::runtime_error);
}

}  // namespace
}  // namespace sgraph
