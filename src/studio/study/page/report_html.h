#pragma once

// Pieces of a report's page. No other file is needed to show it.

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

std::string base64(std::string_view bytes);

struct HtmlCell {
  std::string text;                                         // plain
  double order = std::numeric_limits<double>::quiet_NaN();  // what the column is sorted by; NaN: the text
  std::string hint{};                                       // shown when pointed at
};

// A table that is sorted by a click on a heading.
class HtmlTable {
 public:
  // Headings over so many columns each, together all of them; or never called.
  void group(std::string title, std::size_t columns);
  // Words begin at the left, figures end at the right.
  void column(std::string title, std::string hint = "", bool words = false);
  void row(std::vector<HtmlCell> cells, bool strong = false);
  // A row whose cells after the first are one text: why there are no figures.
  void failure(std::string name, std::string why);

  bool empty() const { return rows_.empty(); }
  std::string html() const;

 private:
  struct Column {
    std::string title, hint;
    bool words = false;
  };
  struct Group {
    std::string title;
    std::size_t columns;
  };
  struct Row {
    std::vector<HtmlCell> cells;
    bool strong = false;
    bool failed = false;
  };
  std::vector<Group> groups_;
  std::vector<Column> columns_;
  std::vector<Row> rows_;
};

// The page; sections without a body are left out. Titles and leads are plain text, bodies HTML.
struct HtmlSection {
  std::string id;
  std::string title;
  std::string lead;
  std::string body;
  bool wide = false;  // tables may take the window's width
};
// What a page has beyond its sections: style rules, and scripts that run in this order after its own.
struct HtmlExtras {
  std::string css{};
  std::vector<std::string> scripts{};
};
// Its Content-Security-Policy forbids every connection, and every script but these.
std::string htmlPage(const std::string& title, const std::string& head, const std::vector<HtmlSection>& sections,
                     const HtmlExtras& extras = {});

// <p> and <pre> of plain text.
std::string htmlParagraph(const std::string& text, const char* kind = "");
std::string htmlCode(const std::string& text);
// HTML that a click on the summary, plain text, unfolds; empty where there is none.
std::string htmlDetails(const std::string& summary, const std::string& body);
// Charts, two abreast where that leaves their text its size, others in a row of their own; empty ones are left out.
std::string htmlFigures(const std::vector<std::string>& svgs);

}  // namespace scanmill
