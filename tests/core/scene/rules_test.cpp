#include "scene/rules.h"

#include <gtest/gtest.h>

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

TEST(Globs, manyStarsStayCheap) {
  const std::string pattern = [] {
    std::string p;
    for (int i = 0; i < 40; ++i) p += "*a";
    return p + "b";
  }();
  EXPECT_FALSE(matches(pattern, std::string(4000, 'a'), kWhere));
}

TEST(Regexes, areSearched) {
  EXPECT_TRUE(matches("/car_[0-9]+/", "old_car_12.obj", kWhere));
  EXPECT_FALSE(matches("/^car/", "old_car_12.obj", kWhere));
  EXPECT_TRUE(matches("/^(Road|Grass)Mesh$/", "GrassMesh", kWhere));
  EXPECT_TRUE(matches("/", "/", kWhere));  // too short for one: a glob
}

TEST(Regexes, badOnesAreRefusedWithTheirPlace) {
  expectInputError([] { matches("/(/", "x", kWhere); }, {"rules.yaml:1:1", "/(/"});
  expectInputError([] { rules("- {match: {node: '/[a/'}, class: car}"); }, {"rules.yaml:1:", "/[a/"});
  expectInputError([] { matches("/(x+)*y/", std::string(100000, 'x'), kWhere); }, {"rules.yaml:1:1", "100000"});
}

TEST(Rules, firstMatchWins) {
  const auto list = rules(
      "- {match: {node: 'Road*'}, class: road}\n"
      "- {match: {node: '*Mesh'}, class: terrain}\n"
      "- {match: any, class: object}\n");
  const auto classOf = [&](std::string_view node) {
    return matchRules(list, {node, "m", "", "f"}).className->className;
  };
  EXPECT_EQ(classOf("RoadMesh"), "road");
  EXPECT_EQ(classOf("GrassMesh"), "terrain");
  EXPECT_EQ(classOf("x"), "object");
}

TEST(Rules, classAndMaterialAreLookedForApart) {
  const auto list = rules(
      "- {match: {material: dark}, material: glass}\n"
      "- {match: {node: House}, class: building}\n"
      "- {match: any, class: object, material: wood}\n");
  const Verdict dark = matchRules(list, {"House", "dark", "", ""});
  EXPECT_EQ(dark.className->className, "building");
  EXPECT_EQ(dark.material->materialName, "glass");
  const Verdict wall = matchRules(list, {"House", "wall", "", ""});
  EXPECT_EQ(wall.className->className, "building");
  EXPECT_EQ(wall.material->materialName, "wood");
  EXPECT_EQ(matchRules(list, {"Tree", "dark", "", ""}).className->className, "object");
  EXPECT_EQ(wall.className->where.line, 2);
}

TEST(Rules, allPatternsMustHold) {
  const auto list = rules("- {match: {node: a, material: b, texture: '*c*', file: '/d$/'}, class: car}\n");
  EXPECT_NE(matchRules(list, {"a", "b", "xcx", "d"}).className, nullptr);
  EXPECT_EQ(matchRules(list, {"A", "b", "xcx", "d"}).className, nullptr);
  EXPECT_EQ(matchRules(list, {"a", "B", "xcx", "d"}).className, nullptr);
  EXPECT_EQ(matchRules(list, {"a", "b", "", "d"}).className, nullptr);
  EXPECT_EQ(matchRules(list, {"a", "b", "xcx", "de"}).className, nullptr);
  EXPECT_EQ(matchRules(list, {"a", "b", "xcx", "d"}).material, nullptr);
}

TEST(Rules, badOnesAreRefusedWithTheirPlace) {
  const auto refuse = [](const std::string& text, const std::vector<std::string>& words) {
    SCOPED_TRACE(text);
    expectInputError([&] { rules(text); }, words);
  };
  refuse("{match: any, class: car}", {"rules.yaml:1", "list"});
  refuse("- {class: car}", {"rules.yaml:1", "match"});
  refuse("- {match: all, class: car}", {"rules.yaml:1", "any", "all"});
  refuse("- {match: {}, class: car}", {"rules.yaml:1", "any"});
  refuse("- {match: {nod: x}, class: car}", {"rules.yaml:1", "nod", "node"});
  refuse("- {match: {node: ''}, class: car}", {"rules.yaml:1", "empty"});
  refuse("- {match: any}", {"rules.yaml:1", "class"});
  refuse("- {match: any, class: car, clas: x}", {"rules.yaml:1", "clas"});
}

}  // namespace
}  // namespace scanmill
