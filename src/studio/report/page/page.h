#pragma once

// A report's page: one HTML file that is shown without any other file, and without a network.

#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "study/text_template.h"

namespace scanmill {

// Additions to a page's template: style rules, and scripts that run in this order after the page's own.
struct PageExtras {
  std::string css{};
  std::vector<std::string> scripts{};
};

// Fills a template of a page's body (see study/text_template.h; all values are escaped) and builds the page; its title
// is the value `title`. Its Content-Security-Policy forbids all connections, and all scripts except its own and those
// of `extras`. Besides Mustache, a body may hold
//
//   <template id="name">     a part that {{>name}} inserts
//   <nav></nav>              links to all headings <h2 id="...">
//   {{#charts.x}}{{>chart}}{{/charts.x}}    a chart, from the value of chartValues()
//   {{#figures}}a b{{/figures}}             the charts `charts.a` and `charts.b`, without those that do not exist
//   {{#table}}                              a table that a click on a heading sorts; omitted if it has no rows
//   rows                                    the path of the list of its rows. A row's `strong` marks the row, its
//                                           `failure` is the reason why the row has no figures
//   == title                                a heading above the columns that follow
//   + path                                  repeats the columns up to the line "-" for each item of this list; each
//                                           row has a list at the same path
//   title | cell | hint | cell's hint       a column of four templates; "< title": a column of words, left-aligned
//   {{/table}}
std::string fillPage(std::string_view body, Json values, const PageExtras& extras = {});

// Returns a chart as the templates need it; null if it has no points.
Json chartValues(const Chart& chart);
// Returns several charts in the same form, by their names.
Json chartValues(const std::vector<Chart>& charts);

// Quotes a word of a command for a shell if necessary; `quote`: always.
std::string shellWord(const std::string& word, bool quote = false);

// Escapes JSON for a <script> element.
std::string scriptJson(const std::string& json);

// The texts of files that CMake embeds in the program: the files of this folder, and Chart.js.
extern const std::string_view kPageLayout, kPageStyle, kPageScript, kChartFigure, kChartScript, kChartLibrary;

}  // namespace scanmill
