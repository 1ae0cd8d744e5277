#pragma once

// Builds the page of a report: one HTML file that needs no other file and no network.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "study/text_template.h"

namespace scanmill {

// Additions to a page: style rules, and scripts, which run in this order after the page's standard scripts.
struct PageExtras {
  std::string css{};
  std::vector<std::string> scripts{};
};

// Fills the template `body` with values (see study/text_template.h) and returns the complete page. All values are
// escaped. The page's title is the value `title`. The page's Content-Security-Policy forbids all connections, and all
// scripts except the standard ones and those in `extras`. In addition to Mustache, the template may contain
//
//   <template id="name">     a text that {{>name}} inserts
//   <nav></nav>              links to all headings <h2 id="...">
//   {{#charts.x}}{{>chart}}{{/charts.x}}    a chart, which is a result of chartValues()
//   {{#figures}}a b{{/figures}}             the charts `charts.a` and `charts.b`, if they exist
//   {{#table}}                              a table, sorted by clicks on headings; omitted if it has no rows
//   rows                                    the path of the list of rows. If `strong` of a row is true, the row is
//                                           emphasised; `failure` is the reason why it has no figures
//   == title                                a heading above the columns that follow
//   + path                                  repeats the columns up to the line "-" for each item of the list at this
//                                           path; every row must have this list
//   title | cell | hint | cell's hint       a column, given by four templates; "< title": left-aligned text
//   {{/table}}
std::string fillPage(std::string_view body, Json values, const PageExtras& extras = {});

// Widths in pixels of charts that share a row of a page, and of charts alone in a row.
inline constexpr int kHalfWidth = 575, kWholeWidth = 1150;

// Returns the values of a chart that the template {{>chart}} needs, see fillPage(); null if the chart has no points.
Json chartValues(const Chart& chart);
// Returns several charts as an object {chart's name: chartValues(chart)}.
Json chartValues(const std::vector<Chart>& charts);

// Returns a word for a shell command, in quotes if the shell needs them or if `quote` is true.
std::string shellWord(const std::string& word, bool quote = false);

// Escapes JSON so that it can stand in a <script> element.
std::string scriptJson(const std::string& json);

// Contents of the files in this folder, which CMake embeds in the program.
extern const std::string_view kPageLayout, kPageStyle, kPageScript;

// Creates the report's folder before the study starts. The folder may exist if it is empty; with `overwrite`, also if
// it contains the file `result`, which shows that the folder has a report of the same kind. Throws InputError
// otherwise. Removes nothing; old files remain until new files replace them.
void prepareReportFolder(const std::filesystem::path& folder, const std::string& result, bool overwrite);

// Removes the file `result`, if it exists: while other files are written, the folder must not look complete.
void beginReport(const std::filesystem::path& folder, const std::string& result);

}  // namespace scanmill
