#include "scenefile/rules.h"

#include <chrono>

#include "tests/support/message_of.h"

namespace scanmill {
namespace {

const Location kWhere{"rules.yaml", 1, 1};

std::vector<Rule> rules(const std::string& text) {
  return readRules(parseYaml(text, "rules.yaml"));
}

TEST(Globs, matchTheWholeName) {
  EXPECT_TRUE(matches("tree", "tree", kWhere));
  EXPECT_FALSE(matches("tree", "tree2", kWhere));
  EXPECT_FALSE(matches("tree", "Tree", kWhere));
  EXPECT_TRUE(matches("tree*", "tree", kWhere));
  EXPECT_TRUE(matches("*", "", kWhere));
  EXPECT_FALSE(matches("?", "", kWhere));
  EXPECT_TRUE(matches("House??Mesh", "House01Mesh", kWhere));
  EXPECT_FALSE(matches("House??Mesh", "House1Mesh", kWhere));
  EXPECT_TRUE(matches("*/leaf*.png", "textures/oak/leaf_1.png", kWhere));
  EXPECT_TRUE(matches("*a*b*c", "xxaybbzzabc", kWhere));
  EXPECT_FALSE(matches("*a*b*c", "xxaybbzzab", kWhere));
  EXPECT_FALSE(matches("", "a", kWhere));
  EXPECT_TRUE(matches("a.c", "a.c", kWhere));
  EXPECT_FALSE(matches("a.c", "abc", kWhere));
}

TEST(Globs, sets) {
  EXPECT_TRUE(matches("car_[0-9]", "car_7", kWhere));
  EXPECT_FALSE(matches("car_[0-9]", "car_x", kWhere));
  EXPECT_TRUE(matches("[abx-z]*", "yes", kWhere));
  EXPECT_TRUE(matches("[!a-c]at", "hat", kWhere));
  EXPECT_FALSE(matches("[!a-c]at", "bat", kWhere));
  EXPECT_TRUE(matches("[]-]x", "]x", kWhere));
  EXPECT_TRUE(matches("[a-]x", "-x", kWhere));
  EXPECT_TRUE(matches("a[b", "a[b", kWhere));  // never closed: itself
  EXPECT_TRUE(matches("*[0-9]m", "12am3m", kWhere));
}

// A matcher that goes back to earlier stars would take a hundred million steps, some tenths of a second.
TEST(Globs, manyStarsStayCheap) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(matches("*a*a*a*a*ab", std::string(120, 'a'), kWhere));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(50));
}

TEST(Regexes, areSearched) {
  EXPECT_TRUE(matches("/car_[0-9]+/", "old_car_12.obj", kWhere));
  EXPECT_FALSE(matches("/^car/", "old_car_12.obj", kWhere));
  EXPECT_TRUE(matches("/^(Road|Grass)Mesh$/", "GrassMesh", kWhere));
  EXPECT_TRUE(matches("/", "/", kWhere));  // too short for one: a glob
}

TEST(Regexes, badOnesAreRefusedWithTheirPlace) {
  expectInputError([] { matches("/(/", "x", kWhere); }, {"rules.yaml:1:1", "/(/"});
  expectInputError([] { matches("/(?=x)/", "x", kWhere); }, {"rules.yaml:1:1", "/(?=x)/", "RE2", "look-around"});
  EXPECT_FALSE(matches("/(x+)*y/", std::string(100000, 'x'), kWhere)) << "in linear time";
}

// Names of files in Latin-1 count as the same characters.
TEST(Patterns, CompareCharactersAndNotBytes) {
  for (const char* const name : {"T\u00FCr", "T\xFCr"}) {
    for (const char* const pattern : {"T?r", "T[\u00FCu]r", "T[!a]r", "T\u00FCr", "T[\u00F0-\u00FF]r", "/^T.r$/",
                                      "/^T[\u00FCu]r$/", "/^T[^a]r$/", "/\u00FC/", "/^T.{1}r/"}) {
      EXPECT_TRUE(matches(pattern, name, kWhere)) << pattern;
    }
    for (const char* const pattern : {"T??r", "T[\u00E4\u00F6]r", "T[!\u00FC]r", "/^T..r$/", "/T[^\u00FC]r/"}) {
      EXPECT_FALSE(matches(pattern, name, kWhere)) << pattern;
    }
  }
  EXPECT_TRUE(matches("?", "\U0001F333", kWhere));
  EXPECT_EQ(matchedText("/_(.)/", "a_\u00FCx", kWhere), "\u00FC");
  EXPECT_EQ(matchedText("/x(a)?/", "xb", kWhere), "") << "a group that takes no part";
}

TEST(Globs, BracesHoldAlternatives) {
  for (const char* const name : {"tree_1", "bush_1", "hedge_low_1", "hedge_high_1"}) {
    EXPECT_TRUE(matches("{tree,bush,hedge_{low,high}}_?", name, kWhere)) << name;
  }
  EXPECT_FALSE(matches("{tree,bush}_?", "hedge_1", kWhere));
  EXPECT_TRUE(matches("{,big_}car", "car", kWhere));
  for (const char* const name : {"{a}", "a"}) EXPECT_TRUE(matches("{a}", name, kWhere)) << name << ": no comma";
  EXPECT_TRUE(matches("{a}{b,c}", "{a}b", kWhere));
  EXPECT_TRUE(matches("{a}{b,c}", "ac", kWhere));
  EXPECT_FALSE(matches("{a}{b,c}", "a{b}", kWhere));
  EXPECT_TRUE(matches("{}", "{}", kWhere));
  EXPECT_FALSE(matches("{}", "", kWhere));
  EXPECT_TRUE(matches("{a,b", "{a,b", kWhere)) << "never closed: a brace";
  EXPECT_TRUE(matches("[{]a[,]b[}]", "{a,b}", kWhere)) << "characters themselves";
  for (const char* const name : {"a{", "x,y", "}"}) EXPECT_TRUE(matches("{a[{],x[,]y,[}]}", name, kWhere)) << name;
  EXPECT_FALSE(matches("{a[{],x[,]y,[}]}", "x", kWhere));
  const std::string deep = std::string(10, '{') + "a" + std::string(10, '}');
  expectInputError([&] { matches(deep, "x", kWhere); }, {"rules.yaml:1:1", "nested"});
}

TEST(Rules, AllPatternsMustHold) {
  const auto list = rules("- {match: {node: a, material: b, texture: '*c*', file: '/d$/'}, class: car}\n");
  EXPECT_TRUE(matchesNames(list[0], {"a", "b", "xcx", "d"}));
  EXPECT_FALSE(matchesNames(list[0], {"A", "b", "xcx", "d"}));
  EXPECT_FALSE(matchesNames(list[0], {"a", "B", "xcx", "d"}));
  EXPECT_FALSE(matchesNames(list[0], {"a", "b", "", "d"}));
  EXPECT_FALSE(matchesNames(list[0], {"a", "b", "xcx", "de"}));
}

// The same rule serves files that write textures' folders and those that do not, with whichever strokes.
TEST(Rules, TexturesAreMatchedByTheirNameOrTheirPath) {
  const auto list = rules(
      "- {match: {texture: 'leaf*.png'}, class: tree}\n"
      "- {match: {texture: 'trees/*'}, class: tree}\n"
      "- {match: {texture: '/trees/'}, class: tree}\n");
  for (const char* const path : {"leaf_1.png", "trees/leaf_1.png", "C:\\art\\trees\\leaf_1.png"}) {
    EXPECT_TRUE(matchesNames(list[0], {"", "", path, ""})) << path;
  }
  EXPECT_TRUE(matchesNames(list[1], {"", "", "trees\\leaf_1.png", ""}));
  EXPECT_FALSE(matchesNames(list[1], {"", "", "leaf_1.png", ""}));
  EXPECT_TRUE(matchesNames(list[2], {"", "", "art\\trees\\leaf_1.png", ""}));
}

TEST(Rules, TrianglesAreMatchedByWhatIsTheirs) {
  const auto list = rules(
      "- {match: {color: '#804020', within: 8}, class: tree}\n"
      "- {match: {color: ['#000000', '#ffffff']}, class: tree}\n"
      "- {match: {box: [[0, 0, 0], [1, 2, 3]]}, class: tree}\n"
      "- {match: {height: [0, 2.5], size: [1, 6]}, class: tree}\n");
  TriangleTraits t;
  t.color = {0x88, 0x38, 0x20};
  EXPECT_TRUE(matchesTriangle(list[0], t));
  t.color = {0x89, 0x40, 0x20};
  EXPECT_FALSE(matchesTriangle(list[0], t));
  EXPECT_FALSE(matchesTriangle(list[1], t));
  t.color = {250, 255, 240};
  EXPECT_TRUE(matchesTriangle(list[1], t)) << "within 16 where nothing is said";
  t.middle = {1, 2, 3};
  EXPECT_TRUE(matchesTriangle(list[2], t));
  t.middle = {1, 2.1, 3};
  EXPECT_FALSE(matchesTriangle(list[2], t));
  t.height = 2.5;
  t.size = 1;
  EXPECT_TRUE(matchesTriangle(list[3], t));
  t.size = 0.9;
  EXPECT_FALSE(matchesTriangle(list[3], t));
  EXPECT_TRUE(list[3].byTriangle());
  EXPECT_EQ(describe(list[3]), "height: 0 to 2.5, size: 1 to 6");
}

TEST(Rules, badOnesAreRefusedWithTheirPlace) {
  expectRefusals([](const std::string& text) { return messageOf([&] { rules(text); }); },
                 {{"{match: any, class: car}", "rules.yaml:1 | list"},
                  {"- {class: car}", "rules.yaml:1 | match"},
                  {"- {match: all, class: car}", "rules.yaml:1 | any | all"},
                  {"- {match: {}, class: car}", "rules.yaml:1 | any"},
                  {"- {match: {nod: x}, class: car}", "rules.yaml:1 | nod | node"},
                  {"- {match: {node: ''}, class: car}", "rules.yaml:1 | empty"},
                  {"- {match: {node: '/[a/'}, class: car}", "rules.yaml:1 | /[a/"},
                  {"- {match: {node: 'Box [l-B]*'}, class: car}", "rules.yaml:1 | Box [l-B]* | write [[] for"},
                  {"- {match: any}", "rules.yaml:1 | class"},
                  {"- {match: any, class: car, drop: true}", "rules.yaml:1 | drop: true"},
                  {"- {match: {color: '#12345g'}, class: car}", "rules.yaml:1 | #8fb34d"},
                  {"- {match: {color: []}, class: car}", "rules.yaml:1 | empty"},
                  {"- {match: {within: 3}, class: car}", "rules.yaml:1 | color"},
                  {"- {match: {height: [3, 1]}, class: car}", "rules.yaml:1 | height"},
                  {"- {match: {size: 3}, class: car}", "rules.yaml:1 | size"},
                  {"- {match: {box: [[0, 0, 0]]}, class: car}", "rules.yaml:1 | box"},
                  {"- {match: {box: [[0, 0, 5], [1, 1, 1]]}, class: car}", "rules.yaml:1 | least"}});
}

}  // namespace
}  // namespace scanmill
