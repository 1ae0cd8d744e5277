#include <fmt/core.h>

#include "base/random.h"
#include "base/terminal.h"
#include "config/value.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

// Texts that YAML, a shell or a terminal might take for something else.
const std::vector<std::string>& oddTexts() {
  static const std::vector<std::string> kTexts{
      "a, b",  "x: y", "# no", "$HOME", "${HOME}", "$$",      "'",    "\"",     "it's",   "a\nb",   " lead",  "trail ",
      "[1]",   "{",    "}",    "null",  "",        "~",       "-",    "- a",    "%a",     "@a",     "a\tb",   "Straße",
      "a: b:", "a #b", "!x",   "&x",    "*x",      "? y",     "\\n",  "a\\b",   "|",      ">",      "`",      "\"\n\\",
      "true",  "1e5",  "a,b",  "a=b",   "\r\n",    "--- x",   "...",  ":x",     "x:",     "a  b",   "\u009b", "",
      "a",     " a ",  "\r\n", "\t",    "\\",      "\x1b[2J", "\x7f", "\u0085", "\u2066", "\ufeff", ":",      "#",
      "[",     "?",    "yes",  "1",     "0x1F",    "$${x}",   "$",    "a$",     "${",     "<<",     "---",    "\uffff"};
  return kTexts;
}

// A tree of maps and lists with texts that YAML or a shell might take for something else.
Value randomTree(std::uint32_t& counter, int depth) {
  static const std::vector<std::string> kPlain{"1", "-1.5", ".5", "+3", "1e-6", "auto", "2 cm", "/a/b-c", "99.5%", "x"};
  const RandomBlock random = randomBlock({.frame = 7, .beam = counter++});
  Value value;
  value.kind = Value::Kind::Scalar;
  if (depth > 0 && random[0] % 3 > 0) {
    value.kind = random[0] % 3 == 1 ? Value::Kind::Sequence : Value::Kind::Map;
    for (std::uint32_t i = 0; i < random[1] % 4; ++i) {
      if (value.kind == Value::Kind::Sequence) {
        value.items.push_back(randomTree(counter, depth - 1));
      } else {
        value.entries.push_back({fmt::format("{}{}", oddTexts()[(random[2] >> (4 * i)) % oddTexts().size()], i),
                                 randomTree(counter, depth - 1)});
      }
    }
  } else if (random[0] % 7 == 0) {
    value.kind = Value::Kind::Null;
  } else if (random[1] % 2 == 0) {
    value.text = kPlain[random[2] % kPlain.size()];
  } else {
    value.quoted = true;
    value.text = oddTexts()[random[2] % oddTexts().size()];
  }
  return value;
}

void expectSameTree(const Value& a, const Value& b) {
  ASSERT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.text, b.text);
  EXPECT_EQ(a.quoted, b.quoted);
  ASSERT_EQ(a.items.size(), b.items.size());
  for (std::size_t i = 0; i < a.items.size(); ++i) expectSameTree(a.items[i], b.items[i]);
  ASSERT_EQ(a.entries.size(), b.entries.size());
  for (std::size_t i = 0; i < a.entries.size(); ++i) {
    EXPECT_EQ(a.entries[i].key, b.entries[i].key);
    expectSameTree(a.entries[i].value, b.entries[i].value);
  }
}

TEST(FlowText, ReadsBackAsTheSameTree) {
  std::uint32_t counter = 0;
  for (int i = 0; i < 2000; ++i) {
    Value tree;
    tree.kind = Value::Kind::Map;
    tree.entries.push_back({"key", randomTree(counter, 3)});
    const std::string text = flowText(tree);
    SCOPED_TRACE(text);
    EXPECT_EQ(text.find('\n'), std::string::npos);
    expectSameTree(parseYaml(text, "f"), tree);
    Value root;
    setValue(root, "a.b=" + text);
    expectSameTree(*root.find("a")->find("b"), tree);
    if (HasFailure()) break;
  }
  EXPECT_EQ(flowText(Value{}), "{}");
}

TEST(QuotedValue, ReadsBackAsTheSameText) {
  std::vector<std::string> texts = oddTexts();
  texts.insert(texts.end(), {"\u202e'\"", "\u009b31m", "\u202egpj", "\u2028\u2029", "\u061c\u200e\u200f", "${HOME:-a}",
                             "\U0001F697"});
  for (const std::string& text : texts) {
    const std::string yaml = quotedValue(text);
    SCOPED_TRACE(yaml);
    for (std::size_t i = 0; i < yaml.size(); i += utf8At(yaml, i).bytes) {
      EXPECT_FALSE(isUnseenControl(utf8At(yaml, i).code));
    }
    const Value read = parseYaml("a: " + yaml, "f").valueOf("a");
    EXPECT_EQ(read.text, text);
    EXPECT_TRUE(read.quoted);
    EXPECT_EQ(parseYaml("[{a: " + yaml + ", b: c}]   # d\n", "f").items.at(0).valueOf("a").text, text);
  }
}

TEST(QuotedValue, RefusesWhatYamlCannotState) {
  expectInputError([] { quotedValue("T\xFCr.obj"); }, {"T\xFCr.obj", "is not UTF-8", "rename it"});
}

}  // namespace
}  // namespace scanmill
