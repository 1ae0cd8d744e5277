#pragma once

// Scans text of files without copying it: lines, words, cells of tables, and numbers.
//
//   for (std::string_view rest = textOfFile(bytes); !rest.empty();) {
//     const std::string_view line = takeLine(rest);
//     for (const std::string_view word : wordsOf(line)) ...

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

namespace scanmill {

inline bool isBlank(char c) {
  return c == ' ' || ('\t' <= c && c <= '\r');
}

// Returns the text without blanks at its ends.
inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  return text;
}

// Returns the text without a byte order mark of UTF-8.
inline std::string_view textOfFile(std::string_view bytes) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return bytes.substr(bytes.starts_with(kMark) ? kMark.size() : 0);
}

// Removes the next line and its end from `rest`, and returns the line without blanks at its ends.
inline std::string_view takeLine(std::string_view& rest, char lineEnd = '\n') {
  const std::size_t end = std::min(rest.find(lineEnd), rest.size());
  const std::string_view line = trimmed(rest.substr(0, end));
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return line;
}

// Removes the next word and the blanks before it from `rest`, and returns the word; it is empty if none is left.
inline std::string_view takeWord(std::string_view& rest) {
  while (!rest.empty() && isBlank(rest.front())) rest.remove_prefix(1);
  std::size_t end = 0;
  while (end < rest.size() && !isBlank(rest[end])) ++end;
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(end);
  return word;
}

// Sets `words` to the words of a text, which blanks separate.
inline void splitWords(std::string_view text, std::vector<std::string_view>& words) {
  words.clear();
  for (std::string_view word = takeWord(text); !word.empty(); word = takeWord(text)) words.push_back(word);
}

inline std::vector<std::string_view> wordsOf(std::string_view text) {
  std::vector<std::string_view> words;
  splitWords(text, words);
  return words;
}

// True if one of the words, which blanks separate, is `word`.
inline bool containsWord(std::string_view words, std::string_view word) {
  for (std::string_view next = takeWord(words); !next.empty(); next = takeWord(words)) {
    if (next == word) return true;
  }
  return false;
}

// Splits a table's line at `separator` and sets `cells` to the cells, without surrounding blanks and quotation marks.
// The separator ' ' stands for any number of blanks. Separators between quotation marks belong to the cell.
inline void splitCells(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  line = trimmed(line);
  const bool hasQuotes = line.find('"') != line.npos;
  for (bool hasNext = true; hasNext;) {
    std::size_t searchBegin = 0;  // where the search for the separator begins: after a quoted cell
    if (hasQuotes) {
      const std::size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
      const std::size_t quote = line.substr(begin).starts_with('"') ? line.find('"', begin + 1) : line.npos;
      if (quote != line.npos) searchBegin = quote;
    }
    const std::size_t end =
        separator == ' ' ? line.find_first_of(" \t", searchBegin) : line.find(separator, searchBegin);
    hasNext = end != line.npos;
    std::string_view cell = trimmed(line.substr(0, end));
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') cell = trimmed(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
    if (hasNext) line.remove_prefix(end + 1);
    if (separator == ' ') line = trimmed(line);
  }
}

// Reads all of `text` as a decimal number, which may begin with a plus sign. Returns false if the text is no number or
// the type cannot hold it; a number too small for the type is 0. Floating-point numbers may be "nan" and "inf".
template <class T>
bool parseNumber(std::string_view text, T& number) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (stop != end) return false;
  if constexpr (std::is_floating_point_v<T>) {
    if (error == std::errc::result_out_of_range) {  // strtod() distinguishes too small from too large
      const double value = std::strtod(std::string(text).c_str(), nullptr);
      if (value > -1 && value < 1) number = 0;
      return value > -1 && value < 1;
    }
  }
  return error == std::errc();
}

}  // namespace scanmill
