#include "assets/meshes/obj/statements.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/text_scan.h"

namespace scanmill::obj {

Statements::Statements(std::string_view text, const std::filesystem::path& file)
    : text_(textOfFile(text)), file_(file.string()) {}

std::string_view Statements::nextLine() {
  ++lines_;
  return takeLine(text_);
}

bool Statements::next() {
  while (!text_.empty()) {
    std::string_view line = nextLine();
    line_ = lines_;
    if (line.empty() || line.front() == '#') continue;
    if (line.back() == '\\') {
      joined_.clear();
      for (; !line.empty() && line.back() == '\\'; line = nextLine()) {
        joined_.append(trimmed(line.substr(0, line.size() - 1))).append(" ");
      }
      joined_.append(line);
      line = trimmed(joined_);
      if (line.empty()) continue;
    }
    keyword_ = takeWord(line);
    rest_ = trimmed(line);
    return true;
  }
  return false;
}

const std::vector<std::string_view>& Statements::words() {
  // "-1.#IND", as Microsoft's library prints NaN, is no number with a comment.
  std::size_t comment = rest_.find('#');
  while (comment != rest_.npos && comment > 0 && rest_[comment - 1] == '.') comment = rest_.find('#', comment + 1);
  splitWords(rest_.substr(0, comment), words_);
  return words_;
}

double Statements::number(std::string_view word) const {
  double number = 0;
  if (parseNumber(word, number)) return number;
  fail(fmt::format("'{}' is not a number{}", word.substr(0, 40),
                   word.find(',') == std::string_view::npos ? "" : ": write decimal points, not commas"));
}

void Statements::fail(const std::string& what) const {
  throw InputError({file_, line_}, fmt::format("{}: {}", keyword_.substr(0, 40), what));
}

}  // namespace scanmill::obj
