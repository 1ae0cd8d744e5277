#include "config/flow_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>

namespace scanmill {

namespace {

// True if a plain scalar of YAML needs no quotes within {...} and [...], after the "=" of --set and in a shell's
// quotes.
bool staysPlain(const std::string& text) {
  const auto word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; };
  const auto inner = [&](char c) { return word(c) || c == '-' || c == '+' || c == '/' || c == '%' || c == ' '; };
  const std::size_t sign = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
  return text.size() > sign && (word(text[sign]) || text[sign] == '/') && text.back() != ' ' &&
         std::all_of(text.begin(), text.end(), inner);
}

// Returns the text in quotes, on one line.
std::string quotedText(const std::string& text) {
  const bool escaped = text.find_first_of("\n\r\t") != std::string::npos;
  std::string quoted;
  for (const char c : text) {
    if (!escaped) {
      quoted += c == '\'' ? std::string("''") : std::string(1, c);
    } else if (c == '\n' || c == '\r' || c == '\t') {
      quoted += c == '\n' ? "\\n" : c == '\r' ? "\\r" : "\\t";
    } else {
      quoted += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    }
  }
  return escaped ? "\"" + quoted + "\"" : "'" + quoted + "'";
}

// Doubles dollars, since a single dollar begins a variable in values (not in keys).
std::string doubledDollars(const std::string& text) {
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
      return value.quoted || !staysPlain(value.text) ? quotedText(doubledDollars(value.text)) : value.text;
    case Value::Kind::Sequence:
      for (const Value& item : value.items) text += (text.empty() ? "" : ", ") + innerText(item);
      return "[" + text + "]";
    case Value::Kind::Map:
      for (const Value::Entry& e : value.entries) {
        text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", staysPlain(e.key) ? e.key : quotedText(e.key),
                            innerText(e.value));
      }
      return "{" + text + "}";
  }
  return text;
}

}  // namespace scanmill
