#include "config/value.h"

#include <fmt/core.h>

#include <cstdlib>

#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string parseError(const std::string& text) {
  return messageOf([&] { parseYaml(text, "x.yaml"); });
}

TEST(ParseYaml, KeepsOrderKindsAndPlaces) {
  const Value root = parseYaml("b: 1\na:\n  - x\n  - {c: 'y', d: }\n", "x.yaml");
  ASSERT_EQ(root.kind, Value::Kind::Map);
  ASSERT_EQ(root.entries.size(), 2u);
  EXPECT_EQ(root.entries[0].key, "b");
  EXPECT_EQ(root.entries[1].key, "a");
  EXPECT_EQ(root.find("b")->where.text(), "x.yaml:1:4");
  EXPECT_EQ(root.find("a")->keyLine, 2);
  EXPECT_EQ(root.find("a")->keyColumn, 1);
  const Value& list = *root.find("a");
  ASSERT_EQ(list.kind, Value::Kind::Sequence);
  ASSERT_EQ(list.items.size(), 2u);
  EXPECT_EQ(list.items[0].where.text(), "x.yaml:3:5");
  EXPECT_FALSE(list.items[0].quoted);
  const Value& c = *list.items[1].find("c");
  EXPECT_EQ(c.text, "y");
  EXPECT_TRUE(c.quoted);
  EXPECT_EQ(c.where.text(), "x.yaml:4:9");
  EXPECT_EQ(list.items[1].find("d")->kind, Value::Kind::Null);
  EXPECT_EQ(list.items[1].find("e"), nullptr);
}

TEST(ParseYaml, EmptyTextIsNull) {
  EXPECT_EQ(parseYaml("", "x.yaml").kind, Value::Kind::Null);
  EXPECT_EQ(parseYaml("# only a comment\n", "x.yaml").kind, Value::Kind::Null);
  EXPECT_EQ(parseYaml("", "x.yaml").where.text(), "x.yaml:1:1");
}

TEST(ParseYaml, ByteOrderMarkAndCarriageReturnsAreHarmless) {
  const Value root = parseYaml(
      "\xEF\xBB\xBF"
      "a: 1\r\nb: two\r\n",
      "x.yaml");
  EXPECT_EQ(root.find("a")->where.text(), "x.yaml:1:4");
  EXPECT_EQ(root.find("b")->text, "two");
  EXPECT_EQ(root.find("b")->where.line, 2);
}

TEST(ParseYaml, AnEmptyValueStandsAtItsKey) {
  const Value root = parseYaml("a:\nb:\n\nc: 1\n", "x.yaml");
  EXPECT_EQ(root.find("a")->where.text(), "x.yaml:1:1");
  EXPECT_EQ(root.find("b")->where.text(), "x.yaml:2:1");
}

TEST(ParseYaml, AliasesAreCopies) {
  const Value root = parseYaml("a: &shared {x: [1, 2]}\nb: *shared\n", "x.yaml");
  ASSERT_NE(root.find("b")->find("x"), nullptr);
  EXPECT_EQ(root.find("b")->find("x")->items[1].text, "2");
  EXPECT_EQ(root.find("b")->keyLine, 2);
}

TEST(ParseYaml, RefusesWithThePlace) {
  EXPECT_EQ(parseError("a: 1\nb: 2\n  \na: 3\n"), "x.yaml:4:1: duplicate key 'a' (first at 1:1)");
  EXPECT_THAT(parseError("a: {b: 1, c: 2, b: 3}"), StartsWith("x.yaml:1:17: duplicate key 'b' (first at 1:5)"));
  EXPECT_THAT(parseError("a: &x [1, *x]"), AllOf(StartsWith("x.yaml:1:11: "), HasSubstr("contains the alias")));
  EXPECT_THAT(parseError("a: *nobody"), AllOf(StartsWith("x.yaml:1:4: "), HasSubstr("anchor is not defined")));
  EXPECT_THAT(parseError("a: 1\n? [1, 2]\n: 2\n"),
              StartsWith("x.yaml:2:3: a key must be text, but this key is a list"));
  EXPECT_THAT(parseError("a: 1\n~: 2\n"), StartsWith("x.yaml:2:1: a key must be text"));
  EXPECT_THAT(parseError("a: &k b\n*k : 2\n"), StartsWith("x.yaml:2:1: a key must be text, but this key is an alias"));
  EXPECT_THAT(parseError("a: &k {b: 1}\nc: {<<: *k}\n"), StartsWith("x.yaml:2:5: merge keys (<<) are not supported"));
  EXPECT_EQ(parseError("a: {'<<': 1}"), "accepted");
  EXPECT_THAT(parseError("a: 1\n---\nb: 2\n"), StartsWith("x.yaml:2:1: a second YAML document"));
  EXPECT_THAT(parseError("- a\nb: 1\n"), AllOf(StartsWith("x.yaml:2:1: "), HasSubstr("indentation")));
  EXPECT_THAT(parseError("a:\n\tb: 1\n"), StartsWith("x.yaml:2:1: the indentation has a tab"));
  EXPECT_THAT(parseError("a:\n  \tb: 1\n"), StartsWith("x.yaml:2:3: the indentation has a tab"));
  EXPECT_THAT(parseError(std::string("a: x\0y", 6)), StartsWith("x.yaml:1:5: the file has a NUL byte"));
  EXPECT_THAT(parseError("a: \"x\\0y\""), StartsWith("x.yaml:1:4: a text has a NUL character"));
  EXPECT_THAT(parseError("a: x\x04y"), StartsWith("x.yaml:1:5: the control character 0x04"));
  EXPECT_THAT(parseError("a: !secret 1"), AllOf(StartsWith("x.yaml:1:4: "), HasSubstr("tag")));
  EXPECT_THAT(parseError("a: 1\nb: [1,\n  2\n"),
              AllOf(StartsWith("x.yaml:2:4: "), HasSubstr("list [ ... ] is not closed")));
  EXPECT_THAT(parseError("a: 1\nb: [1, {c: 2\n"),
              AllOf(StartsWith("x.yaml:2:8: "), HasSubstr("map that is not closed")));
  EXPECT_THAT(parseError("a: 'x"), HasSubstr("quotation mark is not closed"));
  EXPECT_THAT(parseError("a: b: c"), StartsWith("x.yaml:1:5: invalid YAML: a colon"));
}

TEST(ParseYaml, RefusesInvalidUtf8) {
  for (const char* bytes :
       {"\xFF", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xE2\x82", "\x80"}) {
    EXPECT_THAT(parseError(std::string("a: 1\nb: \"") + bytes + "\""), StartsWith("x.yaml:2:5: the byte 0x")) << bytes;
  }
  for (const char* text : {"ä", "€", "😀", "\xEF\xBF\xBD"}) {
    EXPECT_EQ(parseYaml(std::string("a: ") + text, "x.yaml").find("a")->text, text);
  }
}

TEST(ParseYaml, TagsOfTextAreHonoured) {
  const Value root = parseYaml("a: !!str 12\nb: \"12\"\nc: |\n  12\nd: 12\n", "x.yaml");
  EXPECT_TRUE(root.find("a")->quoted);
  EXPECT_TRUE(root.find("b")->quoted);
  EXPECT_TRUE(root.find("c")->quoted);
  EXPECT_FALSE(root.find("d")->quoted);
}

std::string nested(std::size_t depth) {
  return std::string(depth, '[') + std::string(depth, ']');
}

TEST(ParseYaml, DepthIsLimitedTo64) {
  EXPECT_EQ(parseError(nested(64)), "accepted");
  EXPECT_THAT(parseError(nested(65)), AllOf(StartsWith("x.yaml:1:65: "), HasSubstr("64 levels")));
  EXPECT_THAT(parseError(std::string(1'000'000, '[')), HasSubstr("a list that is not closed"));
  std::string block;
  for (int i = 0; i < 3000; ++i) block += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_THAT(parseError(block), StartsWith("x.yaml:65:"));
}

TEST(ParseYaml, AliasesCannotEvadeTheDepthLimit) {
  const std::string chain = "a: &a " + nested(40) + "\nb: ";
  EXPECT_EQ(parseError(chain + std::string(23, '[') + "*a" + std::string(23, ']')), "accepted");
  EXPECT_THAT(parseError(chain + std::string(24, '[') + "*a" + std::string(24, ']')), HasSubstr("64 levels"));
}

TEST(ParseYaml, AliasBombsAreRefused) {
  std::string nodes = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  std::string bytes = "a0: &a0 " + std::string(1 << 16, 'x') + "\n";
  for (int i = 1; i < 30; ++i) {
    const std::string from = fmt::format("*a{}", i - 1);
    const std::string head = fmt::format("a{0}: &a{0} [", i);
    nodes += head + from;
    for (int k = 1; k < 10; ++k) nodes += ", " + from;
    nodes += "]\n";
    bytes += head + from + ", " + from + "]\n";
  }
  EXPECT_THAT(parseError(nodes), AllOf(StartsWith("x.yaml:"), HasSubstr("aliases expanded")));
  EXPECT_THAT(parseError(bytes), AllOf(StartsWith("x.yaml:"), HasSubstr("aliases expanded")));
}

TEST(ParseYaml, AMillionValuesAreTheLimit) {
  std::string list = "[1";
  for (int i = 0; i < 1'000'000; ++i) list += ",1";
  EXPECT_THAT(parseError(list + "]"), HasSubstr("more than 1000000 values"));
}

TEST(ParseYaml, LargeMapsAreCheckedForDuplicatesAtOnce) {
  std::string map;
  for (int i = 0; i < 100'000; ++i) map += fmt::format("k{}: 1\n", i);
  EXPECT_EQ(parseYaml(map, "x.yaml").entries.size(), 100'000u);
  EXPECT_THAT(parseError(map + "k7: 1\n"), StartsWith("x.yaml:100001:1: duplicate key 'k7' (first at 8:1)"));
}

TEST(ParseYaml, FilesOver64MebibytesAreRefused) {
  EXPECT_THAT(parseError(std::string((64u << 20) + 1, ' ')), AllOf(StartsWith("x.yaml: "), HasSubstr("67108864")));
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("sparse.yaml", "a: 1\n");
  std::filesystem::resize_file(path, std::uintmax_t{1} << 40);
  EXPECT_THAT(messageOf([&] { readYaml(path); }), AllOf(StartsWith(path.string()), HasSubstr("67108864")));
}

TEST(ReadYaml, NamesTheFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(readYaml(folder.write("good.yaml", "a: 1\n")).find("a")->text, "1");
  const std::filesystem::path bad = folder.write("bad.yaml", "a: 1\na: 2\n");
  EXPECT_THAT(messageOf([&] { readYaml(bad); }), StartsWith(bad.string() + ":2:1: "));
  for (const std::filesystem::path& path : {folder.path() / "absent.yaml", folder.path()}) {
    EXPECT_THAT(messageOf([&] { readYaml(path); }), StartsWith(path.string() + ": "));
  }
}

class Variables : public ::testing::Test {
 protected:
  Variables() {
    ::setenv("SCANMILL_TEST_SET", "seven", 1);
    ::setenv("SCANMILL_TEST_EMPTY", "", 1);
    ::unsetenv("SCANMILL_TEST_UNSET");
  }
  static std::string expand(const std::string& scalar) { return parseYaml("a: " + scalar, "x.yaml").find("a")->text; }
};

TEST_F(Variables, AreReplacedInsideText) {
  EXPECT_EQ(expand("${SCANMILL_TEST_SET}"), "seven");
  EXPECT_EQ(expand("\"<${SCANMILL_TEST_SET}/${SCANMILL_TEST_SET}>\""), "<seven/seven>");
  EXPECT_EQ(expand("x${SCANMILL_TEST_EMPTY}y"), "xy");
  EXPECT_EQ(expand("${SCANMILL_TEST_SET:-other}"), "seven");
  EXPECT_EQ(expand("${SCANMILL_TEST_UNSET:-../data dir}/x"), "../data dir/x");
  EXPECT_EQ(expand("${SCANMILL_TEST_EMPTY:-other}"), "other");
  EXPECT_EQ(expand("'${SCANMILL_TEST_UNSET:-}'"), "");
}

TEST_F(Variables, ADollarIsADollar) {
  EXPECT_EQ(expand("$$"), "$");
  EXPECT_EQ(expand("$${SCANMILL_TEST_UNSET}"), "${SCANMILL_TEST_UNSET}");
  EXPECT_EQ(expand("$$$${x}"), "$${x}");
  EXPECT_EQ(expand("/car_[0-9]+$/"), "/car_[0-9]+$/");
  EXPECT_EQ(expand("5$"), "5$");
}

TEST_F(Variables, WhatTheyHoldIsNotExpandedAgain) {
  ::setenv("SCANMILL_TEST_SET", "${SCANMILL_TEST_UNSET} [1, 2]", 1);
  EXPECT_EQ(expand("${SCANMILL_TEST_SET}"), "${SCANMILL_TEST_UNSET} [1, 2]");
}

TEST_F(Variables, MistakesNameThePlaceAndTheCure) {
  EXPECT_THAT(parseError("a:\n  - ${SCANMILL_TEST_UNSET}/x\n"),
              AllOf(StartsWith("x.yaml:2:5: "), HasSubstr("`export SCANMILL_TEST_UNSET=...`")));
  EXPECT_THAT(parseError("a: ${SCANMILL_TEST_SET"), AllOf(StartsWith("x.yaml:1:4: "), HasSubstr("closing brace")));
  for (const char* bad : {"${}", "${9X}", "${A B}", "${A:x}", "${A-x}", "${:-x}"}) {
    EXPECT_THAT(parseError(std::string("a: '") + bad + "'"), HasSubstr("is not a variable")) << bad;
  }
  EXPECT_THAT(parseError("a: ${SCANMILL_TEST_SET:-${B}}"), HasSubstr("cannot contain another variable"));
}

TEST(SetValue, ReplacesAndCreates) {
  Value root = parseYaml("seed: 1\na:\n  b:\n    - {c: 1}\n    - {c: 2}\n", "x.yaml");
  setValue(root, "a.b.1.c=7");
  setValue(root, "seed=12");
  setValue(root, "new.deep.key=[1, two]");
  setValue(root, "a.b.0={d: 'x=y'}");
  EXPECT_EQ(root.find("a")->find("b")->items[1].find("c")->text, "7");
  EXPECT_EQ(root.find("a")->find("b")->items[1].find("c")->where.text(), "--set a.b.1.c");
  EXPECT_EQ(root.find("seed")->text, "12");
  EXPECT_EQ(root.find("new")->find("deep")->find("key")->items[1].text, "two");
  EXPECT_EQ(root.find("a")->find("b")->items[0].find("d")->text, "x=y");
  EXPECT_EQ(root.find("a")->find("b")->items[0].find("c"), nullptr);
  EXPECT_EQ(root.entries.size(), 3u);
}

TEST(SetValue, NullTakesAnItemOutOfItsList) {
  Value root = parseYaml("a: [x, {b: 1}, z]\n", "x.yaml");
  setValue(root, "a.1=null");
  ASSERT_EQ(root.find("a")->items.size(), 2u);
  EXPECT_EQ(root.find("a")->items[1].text, "z");
  setValue(root, "a.0=null");
  setValue(root, "a.0=null");
  EXPECT_TRUE(root.find("a")->items.empty());
  EXPECT_THROW(setValue(root, "a.0=null"), InputError);
}

TEST(SetValue, PlusAddsAnItem) {
  Value root = parseYaml("a: [1]\nb: []\n", "x.yaml");
  setValue(root, "a.+={c: 2}");
  setValue(root, "a.1.c=3");
  setValue(root, "b.+=x");
  EXPECT_EQ(root.find("a")->items.at(1).find("c")->text, "3");
  EXPECT_EQ(root.find("b")->items.at(0).text, "x");
  EXPECT_THROW(setValue(root, "a.+.c=1"), InputError);
}

TEST(SetValue, WorksOnAnEmptyFileAndOnEmptyValues) {
  Value root = parseYaml("", "x.yaml");
  setValue(root, "a.b=true");
  EXPECT_EQ(root.find("a")->find("b")->text, "true");
  setValue(root, "a.b=");
  EXPECT_EQ(root.find("a")->find("b")->kind, Value::Kind::Null);
  setValue(root, "a.b.c=1");
  EXPECT_EQ(root.find("a")->find("b")->find("c")->text, "1");
}

TEST(SetValue, RefusesWithThePath) {
  Value root = parseYaml("a: {b: [1, 2]}\ns: x\n", "x.yaml");
  const auto error = [&](const std::string& assignment) { return messageOf([&] { setValue(root, assignment); }); };
  EXPECT_EQ(error("a.b.2=1"),
            "--set a.b.2: item 2 of 'a.b' is out of range: the list has items 0 to 1, and + adds one");
  EXPECT_THAT(error("a.b.99999999999999999999999=1"), HasSubstr("out of range"));
  EXPECT_THAT(error("a.b.-1=1"), HasSubstr("'a.b' is a list: '-1' must be the number of an item"));
  EXPECT_THAT(error("a.b.1x=1"), HasSubstr("'1x' must be the number of an item"));
  EXPECT_EQ(error("s.t=1"), "--set s.t: 's' is a single value and has no 't': set it to a map, such as {key: value}");
  EXPECT_THAT(error("a.b.1.c.d=[x, y]"), HasSubstr("'a.b.1' is a single value and has no 'c'"));
  Value text = parseYaml("no map", "x.yaml");
  EXPECT_THAT(messageOf([&] { setValue(text, "a.b=1"); }), HasSubstr("the file is a single value and has no 'a'"));
  EXPECT_THAT(error("a.b"), AllOf(StartsWith("--set a.b: "), HasSubstr("key=value")));
  EXPECT_THAT(error("=1"), HasSubstr("empty key"));
  EXPECT_THAT(error("a..b=1"), HasSubstr("empty key"));
  EXPECT_THAT(error("a.=1"), HasSubstr("empty key"));
  EXPECT_THAT(error("a.b=[1"), AllOf(StartsWith("--set a.b:1:"), HasSubstr("not closed")));
  std::string deep = "k";
  for (int i = 0; i < 1000; ++i) deep += ".k";
  EXPECT_THAT(error(deep + "=1"), HasSubstr("has more than"));
  EXPECT_EQ(root.find("a")->find("b")->items.size(), 2u);
  EXPECT_EQ(root.entries.size(), 2u);
}

}  // namespace
}  // namespace scanmill
