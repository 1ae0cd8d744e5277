#include "base/terminal.h"

#include <cstdint>
#include <cstdio>

namespace scanmill {

namespace {

constexpr std::uint32_t kNoCharacter = 0xFFFFFFFF;

// Returns the character that begins at `place` and its length in bytes; kNoCharacter for a byte that is not UTF-8.
std::pair<std::uint32_t, std::size_t> characterAt(std::string_view text, std::size_t place) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[place + i]); };
  const unsigned char lead = byte(0);
  const std::size_t length = lead < 0xC0 ? 1 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  if (lead < 0x80) return {lead, 1};
  if (length == 1 || place + length > text.size()) return {kNoCharacter, 1};
  std::uint32_t value = lead & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {kNoCharacter, 1};
    value = value << 6 | (byte(i) & 0x3Fu);
  }
  return {value, length};
}

bool turnsDirection(std::uint32_t c) {
  return c == 0x200E || c == 0x200F || c == 0x061C || (c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
}

std::string made(std::string_view text, bool keepLines) {
  std::string fit;
  fit.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const auto [c, length] = characterAt(text, i);
    if (c == '\n' || c == '\t' || c == '\r') {
      const bool kept = keepLines && c != '\r';
      if (kept) {
        fit += static_cast<char>(c);
      } else {
        fit += c == '\n' ? "\\n" : c == '\t' ? "\\t" : "\\r";
      }
    } else if (c == kNoCharacter) {
      fit += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    } else if (c < 0x20 || (c >= 0x7F && c < 0xA0)) {
      fit += fmt::format("\\x{:02x}", c);
    } else if (turnsDirection(c)) {
      fit += fmt::format("\\u{:04x}", c);
    } else {
      fit += text.substr(i, length);
    }
    i += length;
  }
  return fit;
}

void write(std::FILE* stream, std::string_view text) {
  const std::string fit = forTerminal(text);
  std::fwrite(fit.data(), 1, fit.size(), stream);
}

}  // namespace

std::string forTerminal(std::string_view text) {
  return made(text, true);
}

std::string oneLine(std::string_view text) {
  return made(text, false);
}

std::string indented(std::string_view text) {
  std::string lines;
  for (const char c : made(text, true)) {
    lines += c;
    if (c == '\n') lines += "  ";
  }
  return lines;
}

void writeText(std::string_view text) {
  write(stdout, text);
}

void writeError(std::string_view text) {
  write(stderr, text);
}

}  // namespace scanmill
