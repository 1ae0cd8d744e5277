#pragma once

// Pieces of a report's page, which needs no other file to be shown.

#include <limits>
#include <string>
#include <vector>

namespace scanmill {

struct HtmlCell {
  std::string text;  // plain text
  // The column is sorted by this value; by the text where it is NaN.
  double order = std::numeric_limits<double>::quiet_NaN();
  std::string hint{};  // shown when the cell is pointed at
};

// A table that a click on a heading sorts.
class HtmlTable {
 public:
  // Adds a heading over the next so many columns. Where there are such headings, they must span all columns.
  void group(std::string title, std::size_t columns);
  // Adds a column. Its cells are words, which begin at the left, or figures, which end at the right.
  void column(std::string title, std::string hint = "", bool words = false);
  void row(std::vector<HtmlCell> cells, bool strong = false);
  // Adds a row that says in place of figures why there are none.
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

// A section of a page; it is left out where its body is empty. Title and lead are plain text, the body is HTML.
struct HtmlSection {
  std::string id;
  std::string title;
  std::string lead;
  std::string body;
  bool wide = false;  // tables may take the window's width
};
// What a page has besides its sections: style rules, and scripts that run in this order after the page's own.
struct HtmlExtras {
  std::string css{};
  std::vector<std::string> scripts{};
};
// Puts a page together; sections without a body are left out. Its Content-Security-Policy forbids every connection, and
// every script but its own and those of `extras`.
std::string htmlPage(const std::string& title, const std::string& head, const std::vector<HtmlSection>& sections,
                     const HtmlExtras& extras = {});

// Plain text as a paragraph (<p>), of the CSS class `kind`, or as code (<pre>).
std::string htmlParagraph(const std::string& text, const char* kind = "");
std::string htmlCode(const std::string& text);
// A body that a click on the summary unfolds; the summary is plain text, the body HTML. Empty where the body is empty.
std::string htmlDetails(const std::string& summary, const std::string& body);
// Charts, two abreast where that leaves their text its size, others in a row of their own. Empty ones are left out.
std::string htmlFigures(const std::vector<std::string>& svgs);

}  // namespace scanmill
