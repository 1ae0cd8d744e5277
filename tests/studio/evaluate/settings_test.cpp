#include "evaluate/settings.h"

#include "base/random.h"
#include "config/value.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> textsOf(const std::vector<Value>& values) {
  std::vector<std::string> texts;
  for (const Value& value : values) texts.push_back(flowText(value));
  return texts;
}

std::vector<std::string> namesOf(const std::vector<MethodSetting>& settings) {
  std::vector<std::string> names;
  for (const MethodSetting& s : settings) names.push_back(s.setting.name);
  return names;
}

std::vector<MethodSetting> settingsIn(const std::string& yaml) {
  return readSettings(parseYaml(yaml, "f.yaml"), "settings");
}

TEST(ExpandLists, TheLastListChangesFirst) {
  EXPECT_THAT(textsOf(expandLists(parseYaml("{a: [1, 2], b: x, c: [3, 4, 5]}", "f"), "lists")),
              ElementsAre("{a: 1, b: x, c: 3}", "{a: 1, b: x, c: 4}", "{a: 1, b: x, c: 5}", "{a: 2, b: x, c: 3}",
                          "{a: 2, b: x, c: 4}", "{a: 2, b: x, c: 5}"));
  EXPECT_THAT(textsOf(expandLists(Value{}, "lists")), ElementsAre("{}"));
  EXPECT_THAT(textsOf(expandLists(parseYaml("{a: {b: [1, 2]}}", "f"), "lists")), ElementsAre("{a: {b: [1, 2]}}"));
}

// The setting with number n has the items that n's digits name, in the base of the lists' lengths.
TEST(ExpandLists, GivesTheCartesianProduct) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const RandomBlock random = randomBlock({.beam = i});
    std::vector<std::size_t> lengths;
    std::string yaml = "{";
    std::size_t all = 1;
    for (std::size_t e = 0; e < 1 + random[0] % 4; ++e) {
      lengths.push_back(1 + (random[1] >> (3 * e)) % 4);
      all *= lengths.back();
      yaml += fmt::format("{}k{}: [", e > 0 ? ", " : "", e);
      for (std::size_t item = 0; item < lengths.back(); ++item)
        yaml += fmt::format("{}v{}", item > 0 ? ", " : "", item);
      yaml += "]";
    }
    const std::vector<Value> expanded = expandLists(parseYaml(yaml + "}", "f"), "lists");
    ASSERT_EQ(expanded.size(), all) << yaml;
    for (std::size_t n = 0; n < all; ++n) {
      std::size_t rest = n;
      for (std::size_t e = lengths.size(); e-- > 0; rest /= lengths[e]) {
        EXPECT_EQ(expanded[n].entries[e].value.text, fmt::format("v{}", rest % lengths[e])) << yaml << " " << n;
      }
    }
  }
}

TEST(ReadSettings, NamesAndOptionsAreThoseOfThePipeline) {
  const std::vector<MethodSetting> settings =
      settingsIn("[ray_tracing, {depth_camera: {resolution: [512, 1024], sampling: nearest}}, {particle: {}}]");
  EXPECT_THAT(namesOf(settings), ElementsAre("ray_tracing", "depth_camera resolution=512 sampling=nearest",
                                             "depth_camera resolution=1024 sampling=nearest", "particle"));
  EXPECT_EQ(settings[0].setting.options, "{}");
  EXPECT_EQ(settings[0].setting.assignment(), "method=ray_tracing");
  EXPECT_EQ(settings[1].setting.options, "{resolution: 512, sampling: nearest}");
  EXPECT_EQ(settings[1].setting.assignment(), "method={depth_camera: {resolution: 512, sampling: nearest}}");
  EXPECT_EQ(settings[3].setting.options, "{}");
  for (const MethodSetting& s : settings) {
    EXPECT_EQ(s.choice.entry->name, s.setting.method);
  }
}

TEST(ReadSettings, EveryWrongTextHasItsPlaceAndAWayOut) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> wrongs{
      {"[]", {"f.yaml:1:1", "settings", "at least one item"}},
      {"ray_tracing", {"f.yaml:1:1", "must be a list"}},
      {"\n- ray_traicing", {"f.yaml:2:3", "unknown method 'ray_traicing'", "did you mean 'ray_tracing'"}},
      {"\n- {ray_tracing: {simplfy: 1}}", {"f.yaml:2:18", "unknown key 'simplfy'", "did you mean 'simplify'"}},
      {"- {ray_tracing: {instancing: [auto, some]}}", {"f.yaml:1:37", "instancing may not be 'some'"}},
      {"- {ray_tracing: {simplify: []}}", {"f.yaml:1:28", "the list is empty"}},
      {"- {ray_tracing: 5}", {"f.yaml:1:17", "must be a map", "'5'"}},
      {"- {ray_tracing: {}, particle: {}}", {"f.yaml:1:3", "one pair"}},
      {"- [ray_tracing]", {"f.yaml:1:3", "must be a name or one pair"}},
      {"- ray_tracing\n- particle\n- ray_tracing", {"f.yaml:3:3", "'ray_tracing' is listed twice"}},
      {"- {depth_camera: {resolution: [512, 512]}}", {"f.yaml:1:3", "'depth_camera resolution=512' is listed twice"}},
      {"- {depth_camera: {resolution: [512, 99999]}}", {"f.yaml:1:", "resolution", "99999"}},
      {"- {ray_tracing: {simplify: half}}", {"f.yaml:1:28", "simplify", "'half'"}},
  };
  for (const auto& [yaml, words] : wrongs) {
    SCOPED_TRACE(yaml);
    expectInputError([&, &text = yaml] { settingsIn(text); }, words);
  }
  std::string many = "- {particle: {voxel_m: [";
  for (int i = 1; i <= 30; ++i) many += fmt::format("{}0.{:03}", i > 1 ? ", " : "", i + 50);
  expectInputError([&] { settingsIn(many + "], steps: [" + many.substr(many.find('[') + 1) + "]}}"); },
                   {"f.yaml:1:", "more than 500 settings"});
}

}  // namespace
}  // namespace scanmill
