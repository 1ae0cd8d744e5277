#include "base/terminal.h"

namespace scanmill {

namespace {

enum class LineFeeds { Kept, Escaped };  // what to do with line feeds and tabs

// Escapes bytes that are not UTF-8, characters that control a terminal, carriage returns and, if asked for, line feeds.
std::string escaped(std::string_view text, LineFeeds lineFeeds) {
  std::string safe;
  safe.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const auto [c, length] = utf8At(text, i);
    if (c == '\n' || c == '\t' || c == '\r') {
      if (lineFeeds == LineFeeds::Kept && c != '\r') {
        safe += static_cast<char>(c);
      } else {
        safe += c == '\n' ? "\\n" : c == '\t' ? "\\t" : "\\r";
      }
    } else if (c == kNoCharacter) {
      safe += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    } else if (isUnseenControl(c)) {
      safe += c < 0x100 ? fmt::format("\\x{:02x}", static_cast<unsigned>(c))
                        : fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      safe += text.substr(i, length);
    }
    i += length;
  }
  return safe;
}

}  // namespace

Utf8Character utf8At(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : static_cast<unsigned char>(0xFF);
  };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  if (lead < 0xC2 || lead > 0xF4) return {};
  const std::size_t bytes = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  char32_t code = lead & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3FU);
  }
  const char32_t least = bytes == 4 ? 0x10000 : bytes == 3 ? 0x800 : 0x80;
  if (code < least || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return {};
  return {code, bytes};
}

bool isUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const Utf8Character c = utf8At(text, i);
    if (c.code == kNoCharacter) return false;
    i += c.bytes;
  }
  return true;
}

bool isUnseenControl(char32_t c) {
  return c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0x061C || c == 0x200E || c == 0x200F ||
         (c >= 0x2028 && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069) || c == 0xFEFF;
}

std::string forTerminal(std::string_view text) {
  return escaped(text, LineFeeds::Kept);
}

std::string oneLine(std::string_view text) {
  return escaped(text, LineFeeds::Escaped);
}

std::string indented(std::string_view text) {
  std::string lines;
  for (const char c : forTerminal(text)) {
    lines += c;
    if (c == '\n') lines += "  ";
  }
  return lines;
}

void writeTo(std::FILE* stream, std::string_view text) {
  const std::string safe = forTerminal(text);
  std::fwrite(safe.data(), 1, safe.size(), stream);
}

}  // namespace scanmill
