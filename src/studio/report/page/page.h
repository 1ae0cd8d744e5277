#pragma once

// A report's page: one HTML file that is shown without any other file, and without a network.

#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "study/text_template.h"

namespace scanmill {

// What a page has besides its template: style rules, and scripts that run in this order after the page's own.
struct PageExtras {
  std::string css{};
  std::vector<std::string> scripts{};
};

// Fills a template of a page's body (see study/text_template.h; all values are escaped) and puts the page together; its
// title is the value `title`. Its Content-Security-Policy forbids every connection, and every script but its own and
// those of `extras`. Besides what Mustache has, a body may hold
//
//   <template id="name">     a piece that {{>name}} stands for
//   <nav></nav>              links to all headings <h2 id="...">
//   {{#charts.x}}{{>chart}}{{/charts.x}}    a chart, of what chartValues() made
//   {{#figures}}a b{{/figures}}             the charts `charts.a` and `charts.b`, those of them that are there
//   {{#table}}                              a table that a click on a heading sorts; nothing where it has no rows
//   rows                                    its rows: the path of a list. A row's `strong` marks it, its `failure` says
//                                           why it has no figures
//   == title                                a heading over the columns that follow
//   + path                                  the columns up to the line "-" are there for each item of this list; the
//   row
//                                           has a list of the same path
//   title | cell | hint | cell's hint       a column: templates all; "< title": of words, which begin at the left
//   {{/table}}
std::string fillPage(std::string_view body, Json values, const PageExtras& extras = {});

// A chart as the templates want it; null where it has no points.
Json chartValues(const Chart& chart);
// The same of several, by their names.
Json chartValues(const std::vector<Chart>& charts);

// A word of a command for a shell, in quotes where it needs them; `quote`: always.
std::string shellWord(const std::string& word, bool quote = false);

// JSON that a <script> element can hold.
std::string scriptJson(const std::string& json);

// The texts of files that CMake puts into the program: those of this folder, and Chart.js.
extern const std::string_view kPageLayout, kPageStyle, kPageScript, kChartFigure, kChartScript, kChartLibrary;

}  // namespace scanmill
