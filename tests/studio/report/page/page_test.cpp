#include "report/page/page.h"

#include <set>

#include "base/error.h"
#include "base/file.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string filled(const char* body, Json values) {
  values["title"] = "a <page>";
  const std::string page = fillPage(body, std::move(values));
  return page.substr(page.find("<body>"));
}

TEST(Page, IsOneFileThatRunsItsOwnScriptsOnly) {
  const std::string page = fillPage("", {{"title", "a <page>"}}, {"b{}", {"let x = '</>' < 1;"}});
  EXPECT_THAT(page, HasSubstr("<h1>a &lt;page&gt;</h1>"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'; script-src 'sha256-"));
  EXPECT_THAT(page, HasSubstr("<script>let x = '</>' < 1;</script>"));
  EXPECT_THAT(page, HasSubstr("b{}</style>"));
  for (const char* words : {"http://", "https://", "<link", "@import", "url(", " src=", "unsafe-eval"}) {
    EXPECT_THAT(page, Not(HasSubstr(words)));
  }
}

TEST(Page, LinksToItsHeadingsAndUsesItsPieces) {
  const std::string page = filled(
      "<template id=\"piece\">\n<i>{{word}}</i>\n</template>\n<nav></nav>{{#a:any}}<h2 id=\"a\">A &amp; "
      "B</h2>{{/a:any}}"
      "{{#b:any}}<h2 id=\"b\">B</h2>{{/b:any}}{{>piece}}",
      {{"a", {1}}, {"b", Json::array()}, {"word", "<w>"}});
  EXPECT_THAT(page, HasSubstr("<nav><a href=\"#a\">A &amp; B</a>\n</nav>"));
  EXPECT_THAT(page, HasSubstr("<i>&lt;w&gt;</i>"));
  EXPECT_THAT(page, Not(HasSubstr("template")));
}

TEST(Page, AHeadingWithoutAHintLeavesTheHintOfItsCells) {
  const std::string page =
      filled("{{#table}}\nrows\nname | {{name}} | | about {{name}}\n{{/table}}", {{"rows", {{{"name", "one"}}}}});
  EXPECT_THAT(page, testing::AllOf(HasSubstr("title=\"about one\""), Not(HasSubstr("title=\"|"))));
}

TEST(Page, ATableHasGroupsRepeatedColumnsHintsAndFailures) {
  const Json rows{{{"name", "one"}, {"seconds", 0.0125}, {"strong", true}, {"of", {{{"hits", 1}}, Json::object()}}},
                  {{"name", "two"}, {"failure", "<no>"}}};
  const std::string page = filled(
      "{{#table}}\nrows\nname | {{name}}\n== time & more\n< a scan | {{seconds:s}}!\nits | {{seconds:s}} | hint | "
      "{{seconds}} s\n+ of\n== {{title}}\nhits | {{hits:.1f}}\n-\n{{/table}}",
      {{"rows", rows}, {"of", {{{"title", "a"}}, {{"title", "b"}}}}});
  EXPECT_THAT(page, HasSubstr("<tr class=\"groups\"><th colspan=\"1\"></th><th colspan=\"2\">time & more</th>"
                              "<th colspan=\"1\">a</th><th colspan=\"1\">b</th></tr>"));
  EXPECT_THAT(page, HasSubstr("<th>name</th><th class=\"words\">a scan</th><th title=\"hint\">its</th><th>hits</th>"
                              "<th>hits</th>"));
  EXPECT_THAT(page, HasSubstr("<tr class=\"strong\"><td>one</td><td class=\"words\">12.5 ms!</td>"
                              "<td data-v=\"0.0125\" title=\"0.0125 s\">12.5 ms</td><td data-v=\"1\">1.0</td>"
                              "<td data-v=\"\"></td></tr>"));
  EXPECT_THAT(page, HasSubstr("<tr><td>two</td><td class=\"why\" colspan=\"100\">not measured: &lt;no&gt;</td></tr>"));
  EXPECT_THAT(filled("{{#table}}\nrows\nname | {{name}}\n{{/table}}", {{"rows", Json::array()}}),
              Not(HasSubstr("<table")));
}

TEST(Page, ChartsAreThereWhereTheyHavePoints) {
  Chart chart{.name = "one", .title = "</script>"};
  chart.series.push_back({.name = "<s>", .points = {{1, 2}}});
  const std::string page =
      filled("{{#figures}}one none{{/figures}}", {{"charts", chartValues({chart, Chart{.name = "none"}})}});
  EXPECT_THAT(page, HasSubstr("aria-label=\"&lt;/script&gt;\""));
  EXPECT_THAT(page, HasSubstr(">&lt;s&gt;</text>"));
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find("<svg"), page.rfind("<svg"));
}

TEST(Page, JsonInAScriptHasNoTagsAndNoUnseenControls) {
  EXPECT_EQ(scriptJson("{\"a\": \"<\u202e\u009b\ufeff\u00e9\\u001b\",\n\"b\": 1}"),
            "{\"a\": \"\\u003c\\ufffd\\ufffd\\ufffd\u00e9\\u001b\",\n\"b\": 1}");
}

TEST(Page, AWrongTemplateIsAnError) {
  EXPECT_THROW(fillPage("{{#open}}", {{"title", "t"}}), Error);
}

namespace fs = std::filesystem;
using testing::ElementsAre;

std::set<std::string> filesBelow(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    names.insert(entry.path().lexically_relative(folder).string());
  }
  return names;
}

TEST(ReportFolder, IsMadeWithAllAboveIt) {
  const TemporaryFolder folder;
  prepareReportFolder(folder.path() / "a/b/c", "result.json", false);
  EXPECT_TRUE(fs::is_directory(folder.path() / "a/b/c"));
  prepareReportFolder(folder.path() / "a/b/c", "result.json", false);
  beginReport(folder.path() / "a/b/c", "result.json");
}

TEST(ReportFolder, ForeignFilesAreRefusedAndStay) {
  const TemporaryFolder folder;
  folder.write("notes.txt", "mine");
  for (const bool overwrite : {false, true}) {
    expectInputError([&] { prepareReportFolder(folder.path(), "result.json", overwrite); },
                     {folder.path().string(), "no result.json", "name another folder"});
    EXPECT_EQ(readFile(folder.path() / "notes.txt"), "mine");
  }
  EXPECT_THAT(filesBelow(folder.path()), ElementsAre("notes.txt"));
}

TEST(ReportFolder, AnEarlierReportIsRefusedOrReplaced) {
  const TemporaryFolder folder;
  folder.write("result.json", "old");
  folder.write("index.html", "old");
  folder.write("mine/notes.txt", "mine");
  expectInputError([&] { prepareReportFolder(folder.path(), "result.json", false); },
                   {folder.path().string(), "--overwrite"});
  EXPECT_EQ(readFile(folder.path() / "result.json"), "old");
  prepareReportFolder(folder.path(), "result.json", true);
  EXPECT_EQ(readFile(folder.path() / "result.json"), "old") << "until there is something new";
  beginReport(folder.path(), "result.json");
  EXPECT_THAT(filesBelow(folder.path()), ElementsAre("index.html", "mine", "mine/notes.txt"));
}

TEST(ReportFolder, FilesAndUnusablePlacesAreRefused) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "x");
  expectInputError([&] { prepareReportFolder(file, "result.json", true); }, {file.string(), "is a file"});
  expectInputError([&] { prepareReportFolder(file / "below", "result.json", true); }, {(file / "below").string()});
  EXPECT_EQ(readFile(file), "x");
}

}  // namespace
}  // namespace scanmill
