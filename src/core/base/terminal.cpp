#include "base/terminal.h"

#include <cstdio>

#include "base/utf8.h"

namespace scanmill {

namespace {

std::string made(std::string_view text, bool keepLines) {
  std::string fit;
  fit.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const auto [c, length] = utf8At(text, i);
    if (c == '\n' || c == '\t' || c == '\r') {
      const bool kept = keepLines && c != '\r';
      if (kept) {
        fit += static_cast<char>(c);
      } else {
        fit += c == '\n' ? "\\n" : c == '\t' ? "\\t" : "\\r";
      }
    } else if (c == kNoCharacter) {
      fit += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    } else if (isUnseenControl(c)) {
      fit += c < 0x100 ? fmt::format("\\x{:02x}", static_cast<unsigned>(c))
                       : fmt::format("\\u{:04x}", static_cast<unsigned>(c));
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
