#include "config/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>

#include "base/terminal.h"
#include "base/text_scan.h"

namespace scanmill {

namespace {

unsigned char byteAt(std::string_view text, std::size_t i) {
  return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
}

// True if the line has only blanks, or blanks and a comment, from the index `start` on.
bool isBlankFrom(std::size_t start, std::string_view text) {
  const std::size_t i = text.find_first_not_of(" \t", start);
  return i == std::string_view::npos || text[i] == '\n' || text[i] == '\r' || text[i] == '#';
}

// Returns the value of a variable ${...}; `inside` is the text between its braces: NAME or NAME:-fallback.
std::string variable(std::string_view inside, const Location& where) {
  constexpr std::string_view kLetters = "_ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
  constexpr std::string_view kDigits = "0123456789";
  const std::size_t end = inside.find_first_not_of(std::string(kLetters).append(kDigits));
  const std::string name(inside.substr(0, end));
  const std::string_view fallback = end == std::string_view::npos ? "" : inside.substr(end);  // begins with ":-"
  if (name.empty() || kDigits.find(name[0]) != std::string_view::npos ||
      (!fallback.empty() && !fallback.starts_with(":-"))) {
    throw InputError(where, "{} is not a variable: write ${{NAME}} or ${{NAME:-fallback}}, or $$ for a dollar sign",
                     quotedForMessage(fmt::format("${{{}}}", inside)));
  }
  const char* value = std::getenv(name.c_str());
  if (fallback.empty()) {
    if (value != nullptr) return value;
    throw InputError(where,
                     "the environment variable {0} is not set: set it by `export {0}=...`, or give a fallback as "
                     "${{{0}:-fallback}}",
                     name);
  }
  if (fallback.find("${") != std::string_view::npos) {
    throw InputError(where, "the fallback of ${{{}}} cannot contain another variable", name);
  }
  return value != nullptr && *value != '\0' ? std::string(value) : std::string(fallback.substr(2));
}

}  // namespace

void checkText(std::string_view text, const std::string& file) {
  if (text.size() > kMaxYamlBytes) {
    throw InputError({file}, "has {} bytes, but a YAML file may have at most {}", text.size(), kMaxYamlBytes);
  }
  int line = 1;
  std::size_t lineStart = 0;
  bool isIndentation = true;  // true: the line has only blanks so far
  for (std::size_t i = 0; i < text.size();) {
    const unsigned char c = byteAt(text, i);
    const Location where{file, line, static_cast<int>(i - lineStart) + 1};
    if (c == '\n') {
      ++line;
      lineStart = ++i;
      isIndentation = true;
      continue;
    }
    if (c == 0) throw InputError(where, "the file has a NUL byte: it is not a YAML text in UTF-8");
    if ((c < 0x20 && c != '\t' && c != '\r') || c == 0x7F) {
      throw InputError(where, "the control character 0x{:02X} is not allowed in YAML", c);
    }
    if (c == '\t' && isIndentation && !isBlankFrom(i, text)) {
      throw InputError(where, "the indentation has a tab: YAML allows only spaces there");
    }
    isIndentation = isIndentation && (c == ' ' || c == '\t');
    const Utf8Character character = utf8At(text, i);
    if (character.code == kNoCharacter) throw InputError(where, "the byte 0x{:02X} is not valid UTF-8", c);
    i += character.bytes;
  }
}

std::string expandVariables(std::string_view text, const Location& where) {
  std::string expanded;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t dollar = text.find('$', i);
    expanded += text.substr(i, dollar - i);
    if (dollar == std::string_view::npos) break;
    const char next = dollar + 1 < text.size() ? text[dollar + 1] : '\0';
    if (next == '{') {
      const std::size_t close = text.find('}', dollar);
      if (close == std::string_view::npos) {
        throw InputError(where, "{} lacks its closing brace", quotedForMessage(text.substr(dollar)));
      }
      expanded += variable(text.substr(dollar + 2, close - dollar - 2), where);
      i = close + 1;
    } else {
      expanded += '$';
      i = dollar + (next == '$' ? 2 : 1);
    }
  }
  return expanded;
}

std::string quotedForMessage(std::string_view text) {
  std::size_t end = std::min<std::size_t>(text.size(), 60);
  for (int k = 0; k < 3 && (byteAt(text, end) & 0xC0) == 0x80; ++k) ++end;  // do not cut within a UTF-8 character
  return fmt::format("'{}{}'", oneLine(text.substr(0, end)), end < text.size() ? "..." : "");
}

std::string numberAdvice(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789";
  const std::size_t first = text.find_first_of(kDigits);
  if (first == std::string_view::npos) return {};
  const char next = first + 1 < text.size() ? text[first + 1] : ' ';
  const bool startsWithZero = text[first] == '0' && '0' <= next && next <= '9';
  double number = 0;
  if (parseNumber(text, number) && !startsWithZero) return {};
  return " (write it as 1234.5 or -1.2e-3, without leading zeros or a unit, and the minus sign as -)";
}

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::string lowerExtension(const std::filesystem::path& file) {
  return lowerCase(file.extension().string());
}

}  // namespace scanmill
