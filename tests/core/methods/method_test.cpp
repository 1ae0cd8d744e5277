#include "methods/method.h"

#include <set>

#include "tests/core/methods/depth_camera/worlds.h"

namespace scanmill {
namespace {

TEST(Methods, RowsSayWhatTheirMethodsCan) {
  const Scene nothing;
  std::set<std::array<std::uint8_t, 3>> colors;
  for (const MethodEntry& entry : methods()) {
    EXPECT_EQ(&requireMethod(entry.name, {}), &entry);
    EXPECT_EQ(methodOf(entry.name, nothing)->depthCamera() != nullptr, entry.can.passes) << entry.name;
    EXPECT_TRUE(colors.insert(entry.color).second) << entry.name << " looks like another";
  }
  EXPECT_EQ(findMethod("lidar"), nullptr);
}

TEST(Methods, SomeRowCanBeTheReferenceAndSomeDrawsPasses) {
  EXPECT_TRUE(firstMethodThat(&MethodCapabilities::reference).can.reference);
  EXPECT_TRUE(firstMethodThat(&MethodCapabilities::passes).can.passes);
}

struct Choice {
  const char* method;
  const char* options;
  double tolerance;  // of ranges in a moved scene, relative
  double others;     // the share of beams that may meet something else there

  std::unique_ptr<Method> of(const Scene& scene) const {
    return std::string_view(method) == "depth_camera" ? depthCamera(scene, options) : methodOf(method, scene, options);
  }
};

void PrintTo(const Choice& choice, std::ostream* out) {
  *out << choice.method << " " << choice.options;
}

class EveryMethod : public testing::TestWithParam<Choice> {};

TEST_P(EveryMethod, ThreadsDoNotMatter) {
  const Scene scene = yard();
  const auto beams = spinning(32, 720, -25, 5, 120);
  for (const Shot& shot : {shotAt(beams), moving(beams, 720, 0.4)}) {
    expectSameOnAnyThreads([&] { return traced(*GetParam().of(scene), shot); });
  }
}

TEST_P(EveryMethod, ShotsMayBeTracedAtOnceAndInAnyOrder) {
  const Scene scene = yard();
  const auto beams = spinning(16, 256, -25, 5, 120);
  const std::vector<Shot> shots{shotAt(beams), shotAt(beams, {{}, {3, 1, 0}}), shotAt(beams, {{}, {-6, 0.4, 0}}),
                                moving(beams, 8, 0.3)};
  const auto atOnce = tracedByThreads(*GetParam().of(scene), shots.size(), [&](std::size_t i) { return shots[i]; });
  const auto method = GetParam().of(scene);
  for (std::size_t i = shots.size(); i-- > 0;) expectSameHits(atOnce[i], traced(*method, shots[i]));
}

// Float32 rests a step earlier or later, and pixels' centres lie at a nanometre from an edge.
TEST_P(EveryMethod, MovedSceneGivesTheSameCloud) {
  const auto beams = spinning(32, 512, -25, 5, 120);
  const Scene yardThere = yard(1e7);
  const Scene yardHere = yard();
  const Hits near = traced(*GetParam().of(yardHere), shotAt(beams));
  const Hits far = traced(*GetParam().of(yardThere), shotAt(beams, {{}, {1e7, 1e7, 0}}));
  std::size_t others = 0;
  for (std::size_t b = 0; b < near.size(); ++b) {
    const bool same = near.primitive[b] == far.primitive[b] && near.instance[b] == far.instance[b];
    if (!same || (near.hit(b) && std::abs(far.range[b] / near.range[b] - 1) > GetParam().tolerance)) ++others;
  }
  EXPECT_LE(static_cast<double>(others), GetParam().others * static_cast<double>(near.size()));
}

TEST_P(EveryMethod, OnlyAskedChannelsAreFilled) {
  const Scene scene = yard();
  const Hits hits = traced(*GetParam().of(scene), shotAt(spinning(4, 64, -20, 0)), Channel::Range | Channel::Semantic);
  EXPECT_EQ(hits.range.size(), 256u);
  EXPECT_EQ(hits.semantic.size(), 256u);
  EXPECT_TRUE(hits.instance.empty() && hits.normal.empty() && hits.reflectance.empty() && hits.incidence.empty());
}

TEST_P(EveryMethod, MissesAreZeroed) {
  const Scene scene = yard();
  expectZeroedMiss(traced(*GetParam().of(scene), shotAt(beamsOf({{0, 0, 1}}))));
}

TEST_P(EveryMethod, RangesHaveLimits) {
  const Scene scene = wallsAhead({10, 50});
  const auto method = GetParam().of(scene);
  const auto hit = [&](double minimum, double maximum) {
    return traced(*method, shotAt(beamsOf({{1, 0, 0}}, minimum, maximum))).hit(0);
  };
  EXPECT_TRUE(hit(0, 10.2));
  EXPECT_FALSE(hit(0, 9.8));
  EXPECT_TRUE(hit(9.8, 100));
  EXPECT_FALSE(hit(10.2, 100)) << "nearer surfaces block";
}

INSTANTIATE_TEST_SUITE_P(, EveryMethod,
                         testing::Values(Choice{"ray_tracing", "{instancing: never}", 1e-6, 0},
                                         Choice{"ray_tracing", "{instancing: always}", 1e-6, 0},
                                         Choice{"depth_camera", "{resolution: 512}", 2e-6, 0.0005},
                                         Choice{"particle", "{backend: cpu}", 1e-4, 0.001},
                                         Choice{"particle", "{backend: cpu, refine: none}", 1e-4, 0.001},
                                         Choice{"particle", "{backend: cpu, refine: none, steps: 16}", 1e-4, 0.001}));

}  // namespace
}  // namespace scanmill
