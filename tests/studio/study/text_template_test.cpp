#include "study/text_template.h"

#include <limits>

namespace scanmill {
namespace {

TEST(TextTemplate, WritesFiguresAsPeopleReadThem) {
  const Json values{{"a", {{"scan_s", 0.0054}, {"m", 0.0464}}},
                    {"lost", 1},
                    {"beams", 8},
                    {"none", 0},
                    {"points", 1234567},
                    {"n", 1},
                    {"names", {"x", "y"}}};
  EXPECT_EQ(fillTemplate("{{a.scan_s:s}}, {{a.m:m}}, {{points:count}}, {{points:amount}}", values),
            "5.4 ms, 46.4 mm, 1,234,567, 1.23 M");
  EXPECT_EQ(fillTemplate("{{lost/beams:share}} {{lost/none:share}} {{a.m:.2f}}", values), "12.5 % 0 % 0.05");
  EXPECT_EQ(fillTemplate("{{n:plural=scan}} {{beams:plural=scan}} {{names:join}}", values), "1 scan 8 scans x, y");
  EXPECT_EQ(fillTemplate("{{a.m:unit}} {{#u}}{{a.m:unit}}{{/u}}", {{"a", {{"m", 2}}}, {"u", {{"unit", "mm"}}}}),
            "2 2 mm");
}

TEST(TextTemplate, WhatIsNotThereIsNothing) {
  const Json values{{"null", nullptr},       {"empty", ""}, {"nan", std::numeric_limits<double>::quiet_NaN()},
                    {"list", Json::array()}, {"zero", 0},   {"text", "0"}};
  for (const char* name : {"null", "empty", "nan", "list", "absent", "null:s", "nan:m", "absent/zero:share"}) {
    EXPECT_EQ(fillTemplate("[{{#" + std::string(name) + "}}x{{/" + name + "}}]", values), "[]") << name;
  }
  EXPECT_EQ(fillTemplate("{{#zero}}there{{/zero}}{{#zero:any}}any{{/zero:any}}", values), "there");
}

TEST(TextTemplate, ValuesAreEscapedAndNeverTemplates) {
  const TextEscape escape = [](const std::string& text) { return "<" + text + ">"; };
  EXPECT_EQ(fillTemplate("{{a}} {{{a}}}", {{"a", "{{b}}"}, {"b", "no"}}, escape), "<{{b}}> {{b}}");
  const TemplateMacros twice{{"twice", [](const std::string& text) { return text + text; }}};
  EXPECT_EQ(fillTemplate("{{#l}}{{#twice}}{{a}},{{/twice}}{{/l}}", {{"l", {{{"a", 1}}, {{"a", 2}}}}}, {}, twice),
            "1,1,2,2,");
}

}  // namespace
}  // namespace scanmill
