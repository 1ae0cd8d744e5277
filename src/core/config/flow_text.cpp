#include <fmt/core.h>

#include <algorithm>
#include <cctype>

#include "base/error.h"
#include "base/terminal.h"
#include "config/value.h"

namespace scanmill {

namespace {

// True if a plain scalar of YAML needs no quotes within {...} and [...], after the "=" of --set and in a shell's
// quotes.
bool staysPlain(const std::string& text) {
  const auto word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; };
  const auto inner = [&](char c) { return word(c) || c == '-' || c == '+' || c == '/' || c == '%' || c == ' '; };
  const std::size_t sign = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
  return text.size() > sign && (word(text[sign]) || text[sign] == '/') && text.back() != ' ' &&
         std::ranges::all_of(text, inner);
}

// Returns the text in double quotes, with escapes for characters that nobody sees.
std::string doubleQuoted(std::string_view text) {
  std::string quoted = "\"";
  for (std::size_t i = 0; i < text.size();) {
    const auto [code, bytes] = utf8At(text, i);
    if (isUnseenControl(code)) {
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(code));
    } else {
      if (code == '"' || code == '\\') quoted += '\\';
      quoted += text.substr(i, bytes);
    }
    i += bytes;
  }
  return quoted + '"';
}

// Doubles dollars, since a single dollar begins a variable in values (not in keys).
std::string doubledDollars(std::string_view text) {
  std::string doubled;
  for (const char c : text) doubled += c == '$' ? std::string("$$") : std::string(1, c);
  return doubled;
}

// Returns the text of a value that lies within a list or map.
std::string innerText(const Value& value) {
  return value.kind == Value::Kind::Null ? "null" : flowText(value);
}

}  // namespace

std::string flowText(const Value& value) {
  std::string text;
  switch (value.kind) {
    case Value::Kind::Null:
      return "{}";
    case Value::Kind::Scalar:
      return value.quoted || !staysPlain(value.text) ? doubleQuoted(doubledDollars(value.text)) : value.text;
    case Value::Kind::Sequence:
      for (const Value& item : value.items) text += (text.empty() ? "" : ", ") + innerText(item);
      return "[" + text + "]";
    case Value::Kind::Map:
      for (const Value::Entry& e : value.entries) {
        text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", staysPlain(e.key) ? e.key : doubleQuoted(e.key),
                            innerText(e.value));
      }
      return "{" + text + "}";
  }
  return text;
}

std::string quotedValue(std::string_view text) {
  if (!isUtf8(text)) throw InputError({std::string(text)}, "is not UTF-8, and YAML cannot state it: rename it");
  return doubleQuoted(doubledDollars(text));
}

}  // namespace scanmill
