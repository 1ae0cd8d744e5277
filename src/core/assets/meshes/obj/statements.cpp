#include "assets/meshes/obj/statements.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "base/error.h"

namespace scanmill::obj {

namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

std::string_view trimmed(std::string_view text) {
  const std::size_t from = text.find_first_not_of(kBlanks);
  if (from == std::string_view::npos) return {};
  return text.substr(from, text.find_last_not_of(kBlanks) - from + 1);
}

}  // namespace

Statements::Statements(std::string_view text, const std::filesystem::path& file)
    : text_(text), file_(file.string()), lineEnd_(text.find('\n') == std::string_view::npos ? '\r' : '\n') {
  if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
}

std::string_view Statements::nextLine() {
  const std::size_t end = std::min(text_.find(lineEnd_, at_), text_.size());
  const std::string_view line = trimmed(text_.substr(at_, end - at_));
  at_ = end + 1;
  ++lines_;
  return line;
}

bool Statements::next() {
  while (at_ < text_.size()) {
    std::string_view line = nextLine();
    line_ = lines_;
    if (line.empty() || line.front() == '#') continue;
    if (line.back() == '\\') {
      joined_.clear();
      for (; !line.empty() && line.back() == '\\'; line = at_ < text_.size() ? nextLine() : std::string_view()) {
        joined_.append(trimmed(line.substr(0, line.size() - 1))).append(" ");
      }
      joined_.append(line);
      line = trimmed(joined_);
      if (line.empty()) continue;
    }
    const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
    keyword_ = line.substr(0, end);
    rest_ = trimmed(line.substr(end));
    return true;
  }
  return false;
}

const std::vector<std::string_view>& Statements::words() {
  words_.clear();
  std::size_t comment = rest_.find('#');
  while (comment != std::string_view::npos && comment > 0 && rest_[comment - 1] == '.') {
    comment = rest_.find('#', comment + 1);
  }
  const std::string_view text = rest_.substr(0, comment);
  for (std::size_t at = 0; (at = text.find_first_not_of(kBlanks, at)) != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    words_.push_back(text.substr(at, end - at));
    at = end;
  }
  return words_;
}

double Statements::number(std::string_view word) const {
  // Microsoft's library prints NaN and infinity as "-1.#IND", "1.#QNAN" and "1.#INF".
  if (word.find(".#") != std::string_view::npos) return std::numeric_limits<double>::quiet_NaN();
  double number = 0;
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data() + (word.starts_with('+') ? 1 : 0), end, number);
  if (error == std::errc() && stop == end) return number;
  if (error == std::errc::result_out_of_range && stop == end) return number;
  fail(fmt::format("'{}' is not a number{}", word.substr(0, 40),
                   word.find(',') == std::string_view::npos ? "" : ": write decimal points, not commas"));
}

void Statements::fail(const std::string& what) const {
  throw InputError({file_, line_}, fmt::format("{}: {}", keyword_.substr(0, 40), what));
}

}  // namespace scanmill::obj
