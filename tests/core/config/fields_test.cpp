#include "config/fields.h"

#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

Value yaml(const std::string& text) {
  return parseYaml(text, "pipelines/x.yaml");
}

double number(const std::string& scalar, Range range = {}) {
  return readNumber(yaml(scalar), "n", range);
}

TEST(ReadNumber, AcceptsDecimals) {
  EXPECT_EQ(number("1"), 1);
  EXPECT_EQ(number("-.5"), -.5);
  EXPECT_EQ(number("+2.5"), 2.5);
  EXPECT_EQ(number("1e3"), 1000);
  EXPECT_EQ(number("1E-3"), .001);
  EXPECT_EQ(number("5."), 5);
  EXPECT_EQ(number("0"), 0);
  EXPECT_EQ(number("0.1"), 0.1);
  EXPECT_EQ(number("0.30000000000000004"), 0.1 + 0.2);
  EXPECT_EQ(number("0.01", {0.01, 1000}), 0.01);
  EXPECT_EQ(number("1000", {0.01, 1000}), 1000);
}

TEST(ReadNumber, RefusesWhatOnlySomeReadAsANumber) {
  for (const char* bad :
       {"0x10", "0o17", "017",   "-007", "00.5",   "inf", "-inf", ".inf",  "nan",      ".nan", "1_000",
        "1,5",  "1.5m", "1e",    "e3",   ".",      "-",   "+",    "+-1",   "--1",      "1 2",  "1e999",
        "''",   "'1'",  "\"1\"", "[1]",  "{a: 1}", "~",   "true", "1.2.3", "infinity", "0b1",  "1:30"}) {
    EXPECT_THAT(messageOf([&] { number(bad); }), AllOf(StartsWith("pipelines/x.yaml:1:1: n must be a number"))) << bad;
  }
  EXPECT_THAT(messageOf([] { number("'1'"); }), HasSubstr("not '1' in quotes"));
}

TEST(ReadNumber, MessagesSayWhatToWrite) {
  for (const char* bad : {"1,5", "-010",
                          "\xE2\x88\x92"
                          "5",
                          "5 m"}) {
    EXPECT_THAT(messageOf([&] { number(bad); }), HasSubstr("write it as 1234.5")) << bad;
  }
  for (const char* bad : {"inf", "", "x", "-"}) {
    EXPECT_THAT(messageOf([&] { number(bad); }), testing::Not(HasSubstr("write"))) << bad;
  }
}

TEST(ReadNumber, MessagesTellRangeAndFinding) {
  const Value root = yaml("sensor:\n  name: x\n  rate_hz: abc\n");
  Fields fields(*root.find("sensor"), "sensor");
  EXPECT_EQ(messageOf([&] {
              fields.number("rate_hz", {0.01, 1000}, 10.0);
            }),
            "pipelines/x.yaml:3:12: sensor: rate_hz must be a number from 0.01 to 1000, not 'abc'");
  EXPECT_EQ(messageOf([] {
              number("-1", {0, INFINITY});
            }),
            "pipelines/x.yaml:1:1: n must be a number of at least 0, not '-1'");
  EXPECT_EQ(messageOf([] {
              number("9", {-INFINITY, 2.5});
            }),
            "pipelines/x.yaml:1:1: n must be a number of at most 2.5, not '9'");
  EXPECT_EQ(messageOf([] { number("[1, 2]"); }), "pipelines/x.yaml:1:1: n must be a number, not a list of 2");
  EXPECT_EQ(messageOf([] { number(""); }), "pipelines/x.yaml:1:1: n must be a number, not nothing");
  EXPECT_LT(messageOf([] { number(std::string(100'000, 'x')); }).size(), 150u);
}

TEST(ReadInteger, AcceptsWholeNumbersOfAllSizes) {
  const auto read = [](const std::string& text) {
    return readInteger(yaml(text), "n", std::numeric_limits<std::int64_t>::min(),
                       std::numeric_limits<std::int64_t>::max());
  };
  EXPECT_EQ(read("0"), 0);
  EXPECT_EQ(read("+4"), 4);
  EXPECT_EQ(read("-9223372036854775808"), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(read("9223372036854775807"), std::numeric_limits<std::int64_t>::max());
  for (const char* bad : {"9223372036854775808", "1.0", "1e3", "0x1", "010", "1_000", "'3'", "~", "[3]", "-", "+-1"}) {
    EXPECT_THAT(messageOf([&] { read(bad); }), HasSubstr("n must be a whole number, not")) << bad;
  }
  EXPECT_EQ(messageOf([] { readInteger(yaml("4097"), "rings", 1, 4096); }),
            "pipelines/x.yaml:1:1: rings must be a whole number from 1 to 4096, not '4097'");
}

TEST(ReadBool, OnlyTrueAndFalse) {
  EXPECT_TRUE(readBool(yaml("true"), "b"));
  EXPECT_FALSE(readBool(yaml("false"), "b"));
  for (const char* bad : {"yes", "on", "1", "True", "'true'", "~", "[true]"}) {
    EXPECT_THAT(messageOf([&] { readBool(yaml(bad), "b"); }), HasSubstr("b must be true or false, not")) << bad;
  }
}

TEST(ReadText, TakesScalarsOnly) {
  EXPECT_EQ(readText(yaml("12"), "t"), "12");
  EXPECT_EQ(readText(yaml("''"), "t"), "");
  EXPECT_EQ(messageOf([] { readText(yaml("{a: 1}"), "t"); }), "pipelines/x.yaml:1:1: t must be text, not a map");
  EXPECT_THAT(messageOf([] { readText(yaml("~"), "t"); }), HasSubstr("t must be text, not nothing"));
}

TEST(ReadVectors, NameTheItem) {
  EXPECT_EQ(readVec3(yaml("[1, -2.5, 1e7]"), "v"), (Vec3d{1, -2.5, 1e7}));
  EXPECT_THAT(messageOf([] { readVec3(yaml("[1, 2]"), "v"); }),
              HasSubstr("v must be a list of three numbers [x, y, z]"));
  EXPECT_EQ(messageOf([] { readVec3(yaml("[1, x, 3]"), "v"); }),
            "pipelines/x.yaml:1:5: v[1] must be a number, not 'x'");
  EXPECT_THAT(readNumbers(yaml("[3, 1]"), "l"), ElementsAre(3, 1));
  EXPECT_THAT(readNumbers(yaml("[]"), "l"), IsEmpty());
  EXPECT_THAT(messageOf([] { readNumbers(yaml("[0, 91]"), "l", {-90, 90}); }), HasSubstr("l[1] must be a number from"));
  EXPECT_THAT(messageOf([] { readNumbers(yaml("3"), "l"); }), HasSubstr("l must be a list of numbers, not '3'"));
}

TEST(Nearest, FindsSlipsOfThePen) {
  const std::vector<std::string> names{"rate_hz", "rings", "columns", "range_noise", "yaw_deg", "pitch_deg"};
  EXPECT_EQ(nearest("rat_hz", names), "rate_hz");
  EXPECT_EQ(nearest("colunms", names), "columns");
  EXPECT_EQ(nearest("Rings", names), "rings");
  EXPECT_EQ(nearest("range-noise", names), "range_noise");
  EXPECT_EQ(nearest("yaw", names), "yaw_deg");
  EXPECT_EQ(nearest("ring", names), "rings");
  EXPECT_EQ(nearest("weather", names), "");
  EXPECT_EQ(nearest("x", names), "");
  EXPECT_EQ(nearest("", names), "");
  EXPECT_EQ(nearest(std::string(1'000'000, 'r'), names), "");
  EXPECT_EQ(nearest("a", {}), "");
  EXPECT_EQ(nearest("x", {"y"}), "");
}

TEST(Suggestion, ListsAllWhereNothingIsNear) {
  EXPECT_EQ(suggestion("rat_hz", {"rings", "rate_hz"}), " (did you mean 'rate_hz'?)");
  EXPECT_EQ(suggestion("time_s", {"time_us"}), " (did you mean 'time_us'? Its unit is us, not s)");
  EXPECT_EQ(suggestion("weather", {"rings", "rate_hz"}), " (known: rings, rate_hz)");
  EXPECT_EQ(suggestion("weather", {}), "");
  EXPECT_EQ(suggestion("buss", {"bush", "bus", "buses"}), " (did you mean 'bus'?)");
}

TEST(Fields, ReadsEveryType) {
  const Value root = yaml(
      "n: 2.5\ni: 3\nb: true\nt: word\nc: red\nv: [1, 2, 3]\nl: [1, 2]\nts: [a, b]\none: a\nseed: -1\n"
      "file: ../scenes/s.yaml\nabsolute: /data/s.yaml\n");
  Fields f(root, "test");
  EXPECT_EQ(f.number("n", {0, 10}), 2.5);
  EXPECT_EQ(f.number("none", {0, 10}, 4.0), 4.0);
  EXPECT_EQ(f.integer("i", 0, 10), 3);
  EXPECT_EQ(f.integer("none", 0, 10, 5), 5);
  EXPECT_TRUE(f.boolean("b", false));
  EXPECT_TRUE(f.boolean("none", true));
  EXPECT_EQ(f.text("t"), "word");
  EXPECT_EQ(f.text("none", "fallback"), "fallback");
  EXPECT_EQ(f.choice("c", {"red", "green"}, "green"), "red");
  EXPECT_EQ(f.choice("none", {"red", "green"}, "green"), "green");
  EXPECT_EQ(f.vec3("v", {}), (Vec3d{1, 2, 3}));
  EXPECT_EQ(f.vec3("none", {4, 5, 6}), (Vec3d{4, 5, 6}));
  EXPECT_THAT(f.numbers("l", {}), ElementsAre(1, 2));
  EXPECT_THAT(f.texts("ts"), ElementsAre("a", "b"));
  EXPECT_THAT(f.texts("one"), ElementsAre("a"));
  EXPECT_THAT(f.texts("none"), IsEmpty());
  EXPECT_EQ(f.integer("seed", -5, 5, 0), -1);
  EXPECT_EQ(f.path("file"), "pipelines/../scenes/s.yaml");
  EXPECT_EQ(f.path("absolute"), "/data/s.yaml");
  EXPECT_EQ(f.optionalPath("none"), std::nullopt);
  f.finish();
}

TEST(Fields, RequiredKeysAreNamedWithThePlaceOfTheMap) {
  const Value root = yaml("a: 1\nsensor:\n  rings: 4\n  name:\n");
  Fields f(*root.find("sensor"), "sensor");
  EXPECT_EQ(messageOf([&] { f.number("rate_hz", {}); }), "pipelines/x.yaml:3:3: sensor: the key 'rate_hz' is missing");
  EXPECT_THAT(messageOf([&] { f.text("name"); }), StartsWith("pipelines/x.yaml:4:3: sensor: name must be text"));
}

TEST(Fields, NullCountsAsAbsent) {
  const Value root = yaml("n:\nt: ~\nb: null\np:\nm:\n");
  Fields f(root, "test");
  EXPECT_FALSE(f.has("n"));
  EXPECT_FALSE(f.has("none"));
  EXPECT_EQ(f.find("m"), nullptr);
  EXPECT_EQ(f.number("n", {0, 1}, 0.5), 0.5);
  EXPECT_EQ(f.text("t", "x"), "x");
  EXPECT_TRUE(f.boolean("b", true));
  EXPECT_EQ(f.optionalPath("p"), std::nullopt);
  Fields empty(f.require("m"), "empty");
  empty.finish();
  f.finish();
}

TEST(Fields, WantsAMap) {
  const Value list = yaml("[1]");
  const Value word = yaml("word");
  EXPECT_EQ(messageOf([&] { Fields(list, "sensor"); }),
            "pipelines/x.yaml:1:1: sensor must be a map of keys and values, not a list");
  EXPECT_THAT(messageOf([&] { Fields(word, "sensor"); }), HasSubstr("not 'word'"));
}

TEST(Fields, UnknownKeysAreRefusedWithTheNearest) {
  const Value root = yaml("rings: 4\nname: x\nrat_hz: 10\n");
  Fields f(root, "sensor");
  f.integer("rings", 1, 4096);
  f.number("rate_hz", {0.01, 1000}, 10.0);
  f.text("name", "");
  EXPECT_EQ(messageOf([&] { f.finish(); }),
            "pipelines/x.yaml:3:1: sensor: unknown key 'rat_hz' (did you mean 'rate_hz'?)");
  const Value late = yaml("every_ms: 100\n");
  EXPECT_EQ(messageOf([&] {
              Fields(late, "sensor").number("every_s", {0, 10});
            }),
            "pipelines/x.yaml:1:1: sensor: unknown key 'every_ms' (did you mean 'every_s'? Its unit is s, not ms)");
  const Value other = yaml("rings: 4\n  \nweather: {fog: 1}\n");
  Fields g(other, "sensor");
  g.integer("rings", 1, 4096);
  g.text("name", "");
  EXPECT_EQ(messageOf([&] { g.finish(); }), "pipelines/x.yaml:3:1: sensor: unknown key 'weather' (known: rings, name)");
  EXPECT_TRUE(g.has("weather"));
  EXPECT_EQ(messageOf([&] { g.finish(); }), "accepted") << "a key that was asked for is known";
}

TEST(Fields, UnknownKeysFromTheCommandLineNameTheOption) {
  Value root = yaml("rings: 4\n");
  setValue(root, "colums=8");
  Fields f(root, "sensor");
  f.integer("rings", 1, 4096);
  f.integer("columns", 1, 4096, 1);
  EXPECT_EQ(messageOf([&] { f.finish(); }), "--set colums: sensor: unknown key 'colums' (did you mean 'columns'?)");
}

TEST(Fields, ChoicesSuggest) {
  const Value root = yaml("motion: per_colum\nkind: spinning\n");
  Fields f(root, "shot");
  EXPECT_EQ(messageOf([&] {
              f.choice("motion", {"none", "per_column"}, "none");
            }),
            "pipelines/x.yaml:1:9: shot: motion may not be 'per_colum' (did you mean 'per_column'?)");
  EXPECT_THAT(messageOf([&] { f.choice("kind", {"a", "b"}, "a"); }), HasSubstr("(known: a, b)"));
}

TEST(Fields, PathsAreRelativeToWhoNamesThem) {
  Value root = yaml("file: s.yaml\nempty: ''\n");
  {
    Fields f(root, "test");
    EXPECT_EQ(f.path("file"), "pipelines/s.yaml");
    EXPECT_THAT(messageOf([&] { f.path("empty"); }), HasSubstr("empty must be a path"));
  }
  const auto resolved = [](const Location& where, const std::string& name) {
    Value value;
    value.where = where;
    return resolvePath(value, name);
  };
  EXPECT_EQ(resolved({"x.yaml", 1, 1}, "s.yaml"), "s.yaml");
  EXPECT_EQ(resolved({"/a/b/x.yaml", 1, 1}, "../s.yaml"), "/a/b/../s.yaml");
  EXPECT_EQ(resolved({}, "s.yaml"), "s.yaml");
}

TEST(Fields, ATypoIsReportedBeforeTheKeyThatItHides) {
  const Value root = yaml("outptu: 3\nseed: 1\n");
  Fields f(root, "pipeline");
  EXPECT_EQ(messageOf([&] { f.require("output"); }),
            "pipelines/x.yaml:1:1: pipeline: unknown key 'outptu' (did you mean 'output'?)");
  // A key that is read later is no typo of another.
  EXPECT_THAT(messageOf([&] { f.also({"outptu"}).require("output"); }), HasSubstr("the key 'output' is missing"));
}

TEST(Fields, KeysAreRefusedWithTheReason) {
  const Value root = yaml("speed: 3\npath:\n");
  Fields f(root, "drive");
  EXPECT_EQ(messageOf([&] {
              f.refuse({"path", "speed"}, "is for waypoints");
            }),
            "pipelines/x.yaml:1:8: drive: speed is for waypoints");
  EXPECT_EQ(messageOf([&] { f.refuse({"path"}, "is for waypoints"); }), "accepted");
}

TEST(Fields, KeysNamedAheadAreKnown) {
  const Value root = yaml("name: a\nmout: 1\n");
  Fields f(root, "sensor");
  EXPECT_THAT(messageOf([&] { f.also({"name", "mount", "preset"}).finish(); }), HasSubstr("did you mean 'mount'?"));
  EXPECT_EQ(messageOf([&] { f.also({"mout"}).finish(); }), "accepted");
}

Pose poseOf(const std::string& text) {
  const Value root = yaml(text);
  Fields f(root, "sensor");
  const Pose pose = f.pose();
  f.finish();
  return pose;
}

void expectNear(const Vec3d& a, const Vec3d& b) {
  EXPECT_NEAR(a.x, b.x, 1e-12);
  EXPECT_NEAR(a.y, b.y, 1e-12);
  EXPECT_NEAR(a.z, b.z, 1e-12);
}

TEST(FieldsPose, IsTheIdentityByDefault) {
  EXPECT_EQ(poseOf("{}"), Pose{});
}

TEST(FieldsPose, AnglesAreDegrees) {
  const Pose yawed = poseOf("{position: [1, 2, 3], yaw_deg: 90}");
  expectNear(yawed * Vec3d{1, 0, 0}, {1, 3, 3});
  expectNear(poseOf("{pitch_deg: 90}") * Vec3d{1, 0, 0}, {0, 0, -1});
  expectNear(poseOf("{roll_deg: 90}") * Vec3d{0, 1, 0}, {0, 0, 1});
}

TEST(FieldsPose, QuaternionsAreNormalised) {
  const Pose pose = poseOf("rotation: [2, 0, 0, 2]");
  expectNear(pose * Vec3d{1, 0, 0}, {0, 1, 0});
  EXPECT_EQ(poseOf("rotation: [1e-300, 0, 0, 0]").rotation, Quat{});
  EXPECT_EQ(poseOf("rotation: [1e300, 0, 0, 0]").rotation, Quat{});
}

TEST(FieldsPose, RefusesWhatIsNoRotation) {
  EXPECT_THAT(messageOf([] { poseOf("rotation: [0, 0, 0, 0]"); }),
              AllOf(StartsWith("pipelines/x.yaml:1:11: sensor: rotation"), HasSubstr("non-zero length")));
  EXPECT_THAT(messageOf([] { poseOf("rotation: [1, 0, 0]"); }),
              HasSubstr("a quaternion [w, x, y, z], not a list of 3"));
  EXPECT_THAT(messageOf([] { poseOf("{rotation: [1, 0, 0, 0], yaw_deg: 0}"); }), HasSubstr("cannot be given together"));
  EXPECT_THAT(messageOf([] { poseOf("{yaw: 3}"); }), HasSubstr("unknown key 'yaw' (did you mean 'yaw_deg'?)"));
}

TEST(ReadList, WantsAnItem) {
  EXPECT_EQ(readList(yaml("[a, b]"), "l").size(), 2u);
  for (const char* bad : {"[]", "3", "{a: 1}", "~"}) {
    EXPECT_THAT(messageOf([&] { readList(yaml(bad), "l"); }), HasSubstr("l must be a list with at least one item"));
  }
}

TEST(ReadIntegers, DotsStandForAllInBetween) {
  const auto read = [](const std::string& text) {
    std::vector<std::int64_t> values;
    for (const PlacedInteger& n : readIntegers(yaml(text), "seeds", 0, 1000)) values.push_back(n.value);
    return values;
  };
  EXPECT_THAT(read("[1, ..., 5]"), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(read("[7, 1, ..., 3, 9]"), ElementsAre(7, 1, 2, 3, 9));
  EXPECT_THAT(read("[1, ..., 2]"), ElementsAre(1, 2));
  EXPECT_THAT(read("[]"), IsEmpty());
  EXPECT_THAT(messageOf([&] { read("[..., 5]"); }), HasSubstr("between two numbers"));
  EXPECT_THAT(messageOf([&] { read("[5, ...]"); }), HasSubstr("between two numbers"));
  EXPECT_THAT(messageOf([&] { read("[5, ..., 5]"); }), HasSubstr("seeds"));
  EXPECT_THAT(messageOf([&] { read("[5, ..., 1001]"); }), HasSubstr("1000"));
  EXPECT_THAT(messageOf([&] { read("5"); }), HasSubstr("a list of integers"));
}

}  // namespace
}  // namespace scanmill
