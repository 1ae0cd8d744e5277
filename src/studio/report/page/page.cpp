#include "report/page/page.h"

#include <fmt/core.h>

#include <charconv>
#include <regex>

#include "base/error.h"
#include "base/hash.h"
#include "base/terminal.h"
#include "base/text_scan.h"
#include "charts/svg_text.h"

namespace scanmill {

namespace {

constexpr int kMostHalfWidth = 870;  // pixels; wider charts stand alone in a row

// Splits a line that describes a table's column (see fillPage()) at " | " into four parts; missing parts are empty.
std::vector<std::string> cellParts(std::string_view line) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin != std::string::npos;) {
    const std::size_t end = line.find(" | ", begin);
    parts.emplace_back(trimmed(line.substr(begin, end - begin)));
    begin = end == std::string::npos ? end : end + 2;  // the blank may be that of the next separator
  }
  parts.resize(4);
  return parts;
}

// Returns the HTML attribute with the text that is shown when the mouse points at a cell; empty if `text` is empty.
std::string titleAttribute(const std::string& text) {
  return text.empty() ? "" : fmt::format(" title=\"{}\"", text);
}

// Returns the template of the HTML attribute by which the page's script sorts a table: the first number of the cell's
// template, with nine significant digits. Returns an empty text if the cell's template has no number.
std::string sortAttribute(const std::string& cell) {
  static const std::regex figure(R"(\{\{([^{}#^/:!>&]+(/[^{}:]+)?):[^{}]*\}\})");
  std::smatch found;
  return std::regex_search(cell, found, figure) ? fmt::format(" data-v=\"{{{{{}:.9g}}}}\"", found[1].str()) : "";
}

// Converts the description of a table (see fillPage()) to a Mustache template. The first column, which names the row,
// stands outside of "+" groups. A row with `failure` has one wide cell in place of the other columns.
std::string tableTemplate(const std::string& text) {
  // The values' path of the list of rows, the path after "+" and the title after "==".
  std::string rowsPath, repeatedPath, groupTitle;
  std::string groups, heads, cells;   // templates of the cells: of the two rows of headings, and of a row of values
  int columns = 0, groupColumns = 0;  // numbers of columns so far: in all, and in the current group
  const auto endGroup = [&] {
    if (groupColumns > 0) groups += fmt::format("<th colspan=\"{}\">{}</th>", groupColumns, groupTitle);
    groupColumns = 0;
  };
  const auto addToEachRow = [&](const std::string& tag) {
    groups += tag;
    heads += tag;
    cells += tag;
  };
  for (std::string_view rest = text; !rest.empty();) {
    const std::string line(takeLine(rest));
    if (line.empty()) continue;
    if (rowsPath.empty()) {
      rowsPath = line;
    } else if (line.starts_with("== ")) {
      endGroup();
      groupTitle = line.substr(3);
    } else if (line.starts_with("+ ")) {
      endGroup();
      repeatedPath = line.substr(2);
      addToEachRow("{{#" + repeatedPath + "}}");
    } else if (line == "-") {
      endGroup();
      addToEachRow("{{/" + repeatedPath + "}}");
      groupTitle.clear();
    } else {
      const std::vector<std::string> parts = cellParts(line);
      const std::string &title = parts[0], &cell = parts[1], &hint = parts[2], &cellHint = parts[3];
      const bool isText = title.starts_with("< ");
      const std::string style = isText ? " class=\"words\"" : "";
      heads += fmt::format("<th{}{}>{}</th>", style, titleAttribute(hint), isText ? title.substr(2) : title);
      cells +=
          fmt::format("<td{}{}{}>{}</td>", style, isText ? "" : sortAttribute(cell), titleAttribute(cellHint), cell);
      if (columns++ == 0)
        cells += "{{#failure}}<td class=\"why\" colspan=\"100\">not measured: {{failure}}</td>{{/failure}}{{^failure}}";
      ++groupColumns;
    }
  }
  endGroup();
  cells += "{{/failure}}";
  const bool grouped = text.find("\n==") != std::string::npos;
  return fmt::format(
      "{{{{#{0}:any}}}}<div class=\"scroller\"><p class=\"hint\">Scroll sideways for more columns \xE2\x86\x92</p>"
      "<div class=\"table\" tabindex=\"0\"><table><thead>{1}<tr class=\"columns\">{2}</tr></thead><tbody>\n"
      "{{{{#{0}}}}}<tr{{{{#strong}}}} class=\"strong\"{{{{/strong}}}}>{3}</tr>\n{{{{/{0}}}}}"
      "</tbody></table></div></div>{{{{/{0}:any}}}}",
      rowsPath, grouped ? "<tr class=\"groups\">" + groups + "</tr>" : "", heads, cells);
}

std::string figuresTemplate(const std::string& text) {
  std::string figures;
  for (const std::string_view name : wordsOf(text))
    figures += fmt::format("{{{{#charts.{0}}}}}{{{{>chart}}}}{{{{/charts.{0}}}}}", name);
  return "<div class=\"figures\">" + figures + "</div>";
}

// Returns a script's source expression for a Content-Security-Policy (CSP 3, 2.3.1): its SHA-256 in base64.
std::string scriptSource(const std::string& script) {
  const std::string hex = sha256(script);
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    unsigned value = 0;
    std::from_chars(hex.data() + i, hex.data() + i + 2, value, 16);
    bytes += static_cast<char>(value);
  }
  return fmt::format(" 'sha256-{}'", base64(bytes));
}

// Removes each <template id="name">text</template> from `body` and stores the text in `values` under the name.
std::string withoutPartials(std::string body, Json& values) {
  constexpr std::string_view kBegin = "<template id=\"", kEnd = "</template>\n";
  for (std::size_t begin = body.find(kBegin); begin != std::string::npos; begin = body.find(kBegin)) {
    const std::size_t name = begin + kBegin.size(), nameEnd = body.find("\">\n", name), end = body.find(kEnd, nameEnd);
    values[body.substr(name, nameEnd - name)] = body.substr(nameEnd + 3, end - nameEnd - 3);
    body.erase(begin, end + kEnd.size() - begin);
  }
  return body;
}

// Returns links to all headings <h2 id="..."> of a page.
std::string navigation(const std::string& body) {
  constexpr std::string_view kHeading = "<h2 id=\"";
  std::string links;
  for (std::size_t at = body.find(kHeading); at != std::string::npos; at = body.find(kHeading, at + 1)) {
    const std::size_t id = at + kHeading.size(), idEnd = body.find("\">", id), title = idEnd + 2;
    links += fmt::format("<a href=\"#{}\">{}</a>\n", body.substr(id, idEnd - id),
                         body.substr(title, body.find("</h2>", title) - title));
  }
  return links;
}

}  // namespace

std::string fillPage(std::string_view body, Json values, const PageExtras& extras) {
  const TextEscape escape = [](const std::string& text) { return escapeXml(text); };
  values["chart"] = "<figure class=\"chart{{#wide}} wide{{/wide}}\">{{{svg}}}</figure>";
  std::string filledBody = fillTemplate(withoutPartials(std::string(body), values), values, escape,
                                        {{"table", tableTemplate}, {"figures", figuresTemplate}});
  constexpr std::string_view kNavigation = "<nav></nav>";
  const std::size_t nav = filledBody.find(kNavigation);
  if (nav != std::string::npos) filledBody.insert(nav + std::string_view("<nav>").size(), navigation(filledBody));
  Json layout{
      {"title", values["title"]}, {"css", std::string(kPageStyle) + extras.css}, {"body", std::move(filledBody)}};
  std::vector<std::string> scripts{std::string(kPageScript)};
  scripts.insert(scripts.end(), extras.scripts.begin(), extras.scripts.end());
  std::string sources;
  for (const std::string& script : scripts) sources += scriptSource(script);
  layout["sources"] = sources;
  layout["libraries"] = scripts.size() > 1;
  layout["scripts"] = std::move(scripts);
  return fillTemplate(std::string(kPageLayout), layout, escape);
}

Json chartValues(const Chart& chart) {
  if (!hasPoints(chart)) return {};
  const bool wide = chart.width > kMostHalfWidth;
  Chart fitted = chart;
  fitted.width = wide ? kWholeWidth : kHalfWidth;
  return {{"wide", wide}, {"svg", drawSvg(fitted)}};
}

Json chartValues(const std::vector<Chart>& charts) {
  Json values;
  for (const Chart& chart : charts) values[chart.name] = chartValues(chart);
  return values;
}

std::string shellWord(const std::string& word, bool quote) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./,:+@%=";
  if (!quote && !word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted;
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return "'" + quoted + "'";
}

// Replaces "<" by its escape sequence, which means the same in JSON strings, and invisible control characters by
// U+FFFD, as escapeXml() does. Both occur only in strings. ASCII control characters are already escaped in JSON.
std::string scriptJson(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  for (std::size_t i = 0; i < json.size();) {
    const auto [code, bytes] = utf8At(json, i);
    safe += code == '<'                             ? "\\u003c"
            : code >= 0x7F && isUnseenControl(code) ? "\\ufffd"
                                                    : std::string_view(json).substr(i, bytes);
    i += bytes;
  }
  return safe;
}

namespace fs = std::filesystem;

void prepareReportFolder(const fs::path& folder, const std::string& result, bool overwrite) {
  try {
    if (fs::exists(folder) && !fs::is_directory(folder)) {
      throw InputError({folder.string()}, "is a file: name another folder");
    }
    fs::create_directories(folder);
    if (fs::is_empty(folder)) return;
    if (!fs::exists(folder / result)) {
      throw InputError({folder.string()}, "has files, but no {}: name another folder", result);
    }
    if (!overwrite) throw InputError({folder.string()}, "has a report: add --overwrite, or name another folder");
  } catch (const fs::filesystem_error& error) {
    throw InputError({folder.string()}, "cannot be used as the folder of a report: " + error.code().message());
  }
}

void beginReport(const fs::path& folder, const std::string& result) {
  std::error_code failure;
  fs::remove(folder / result, failure);
  if (failure) throw Error("{}: cannot be removed: {}", (folder / result).string(), failure.message());
}

}  // namespace scanmill
