// What somebody who has read only the README tries, and is told.

#include <fmt/core.h>

#include <set>

#include "base/file.h"
#include "formats/format.h"
#include "gpu/compute.h"
#include "methods/method.h"
#include "sense/sense.h"
#include "tests/commands/program.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class FirstSteps : public SmallWorld {};

TEST_F(FirstSteps, NamesOfTheProgramsFilesWorkFromAnywhere) {
  const std::string sensor = "sensors=[{preset: os1_128}]";
  const Outcome o = scanmill({"plan", pipeline_, "--set", sensor, "--set", "labels=semantic_kitti"});
  EXPECT_EQ(o.code, 0) << o.error;
  EXPECT_THAT(o.out, HasSubstr("OS1-128"));
  folder_.write("named.yaml",
                "ontology: semantic_kitti\nmaterials: materials\nobjects:\n"
                "  - {primitive: box, size: [1, 1, 1], class: car, material: brick}\n");
  EXPECT_EQ(scanmill({"info", at("named.yaml")}).code, 0);
  EXPECT_EQ(scanmill({"plan", pipeline_, "--set", "scenes.0.scene=named"}).code, 0);
  EXPECT_EQ(scanmill({"plan", "street"}).code, 0);
}

TEST_F(FirstSteps, QuietIsOneLine) {
  const Outcome o = scanmill({"generate", pipeline_, "-q", "-o", at("out")});
  EXPECT_EQ(o.error, "");
  EXPECT_THAT(o.out, HasSubstr("4 samples in 1 shard,"));
  EXPECT_EQ(std::count(o.out.begin(), o.out.end(), '\n'), 1);
}

TEST_F(FirstSteps, InfoOfAnAssetTellsItsSizeAndHowItWasRead) {
  folder_.write("shed.obj",
                "o Wall\nv 0 0 0\nv 400 0 0\nv 400 0 250\nf 1 2 3\no Knob\nv 0 0 100\nv 5 0 100\nv 5 1 103\n"
                "f 4 5 6\n");
  const Outcome z = scanmill({"info", at("shed.obj")});
  EXPECT_THAT(z.out, AllOf(HasSubstr("from [0, 0, 0] to [400, 1, 250]: 400 x 1 x 250 m"), HasSubstr("unit: 1"),
                           HasSubstr("up: z"), ContainsRegex("Knob +5 x 1 x 3 m +100 +1\n")));
  const Outcome y = scanmill({"info", at("shed.obj"), "--unit", "0.01", "--up", "y"});
  EXPECT_THAT(y.out,
              AllOf(HasSubstr("from [0, -2.5, 0] to [4, 0, 0.01]"), HasSubstr("unit: 0.01"), HasSubstr("up: y")));
}

// The keys that a reader of options asks for, from its own refusal of another.
template <class Make>
std::set<std::string> keysRead(const Make& make) {
  const Value value = parseYaml("{qqqqqqqqqqqqqqqqqqqq: 1}", "x.yaml");
  Fields fields(value, "options");
  std::string text = messageOf([&] { make(fields); });
  EXPECT_THAT(text, HasSubstr("unknown key"));
  std::set<std::string> keys;
  const std::size_t at = text.find("(known: ");
  if (at == std::string::npos) return keys;
  for (text = text.substr(at + 8, text.size() - at - 9); !text.empty();) {
    const std::size_t end = std::min(text.find(", "), text.size());
    keys.insert(text.substr(0, end));
    text.erase(0, end + 2);
  }
  return keys;
}

std::set<std::string> keysTold(std::string_view text) {
  std::set<std::string> keys;
  while (!text.empty()) {
    keys.emplace(text.substr(0, text.find(':')));
    text.remove_prefix(text.find('\n') == std::string_view::npos ? text.size() : text.find('\n') + 1);
  }
  return keys;
}

TEST(Keys, ListsNameAllKeysAndNoOthers) {
  for (const EffectEntry& e : effects()) EXPECT_EQ(keysTold(e.keys), keysRead(e.make)) << e.name;
  for (const FormatEntry& e : formats()) EXPECT_EQ(keysTold(e.keys), keysRead(e.make)) << e.name;
  const Scene scene;
  for (const MethodEntry& e : methods()) {
    EXPECT_EQ(keysTold(e.keys), keysRead([&](Fields& options) { e.make(scene, options); })) << e.name;
  }
}

TEST(Keys, AreListedForOneKindOnly) {
  const Outcome effects = scanmill({"list", "effects"});
  EXPECT_THAT(effects.out,
              AllOf(HasSubstr("keys, with their defaults"), HasSubstr("\n  range_noise\n    sigma_m: 0 m")));
  EXPECT_THAT(scanmill({"list", "formats"}).out, AllOf(HasSubstr("max_error_mm: 1 mm"), HasSubstr("  csv: none\n")));
  EXPECT_THAT(scanmill({"list"}).out, Not(HasSubstr("sigma_m")));
  EXPECT_THAT(scanmill({"list", "range_noise"}).out,
              AllOf(HasSubstr("effect range_noise: "), HasSubstr("sigma_m: 0 m"), Not(HasSubstr("speckle"))));
  EXPECT_THAT(scanmill({"list"}).out, Not(HasSubstr("devices")));
}

TEST(Devices, AreListedWhereTheyAreAskedFor) {
  SKIP_WITHOUT_GL();
  const Outcome listed = scanmill({"list", "devices"});
  EXPECT_EQ(listed.code, 0);
  EXPECT_THAT(listed.out, AllOf(HasSubstr(findDevices().front().driver), HasSubstr("SCANMILL_GL_DEVICE")));
}

}  // namespace
}  // namespace scanmill
