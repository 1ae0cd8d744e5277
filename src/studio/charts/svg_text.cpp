#include "charts/svg_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "base/terminal.h"

namespace scanmill {

namespace {

// Widths of the characters 32 to 126, in thousandths of the font size (Adobe's metrics of Helvetica, 1997).
constexpr std::array<int, 95> kWidths{278,  278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
                                      556,  556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
                                      1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
                                      667,  778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
                                      333,  556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
                                      556,  556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584};
// Factor by which texts in fonts such as DejaVu Sans and Verdana are wider than in Helvetica.
constexpr double kOtherFonts = 1.12;
constexpr double kBold = 1.07;  // factor by which bold text is wider

// Returns the UTF-8 character that begins at index `byte`. Its code is 0 if XML does not allow the character, if the
// character is an invisible control character, or if no character begins at `byte`.
Utf8Character characterAt(std::string_view text, std::size_t byte) {
  const Utf8Character c = utf8At(text, byte);
  const bool isBlank = c.code == '\t' || c.code == '\n' || c.code == '\r';
  const bool isNonCharacter = (c.code & 0xFFFE) == 0xFFFE;  // U+FFFE and U+FFFF of each plane
  const bool isForbidden = c.code == kNoCharacter || (isUnseenControl(c.code) && !isBlank) || isNonCharacter;
  return isForbidden ? Utf8Character{0, c.bytes} : c;
}

using Escape = std::pair<char32_t, std::string_view>;
// Replacements of characters in XML. Code 0 stands for characters that XML does not allow, which become U+FFFD.
constexpr Escape kEscapes[]{{'&', "&amp;"},  {'<', "&lt;"},   {'>', "&gt;"},
                            {'"', "&quot;"}, {'\'', "&#39;"}, {0, "\xEF\xBF\xBD"}};

// Returns a character's width in thousandths of the font size. The widths of characters that are not ASCII are
// estimated: from U+1100 on, where the scripts of East Asia begin, characters are about square.
double widthOf(char32_t code) {
  if (code >= 32 && code < 127) return kWidths[code - 32];
  return code >= 0x1100 ? 1000 : 600;
}

}  // namespace

std::string escapeXml(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (std::size_t i = 0; i < text.size();) {
    const Utf8Character c = characterAt(text, i);
    const auto escape = std::ranges::find(kEscapes, c.code, &Escape::first);
    out += escape != std::end(kEscapes) ? escape->second : text.substr(i, c.bytes);
    i += c.bytes;
  }
  return out;
}

double svgTextWidth(std::string_view text, double fontSize, FontWeight weight) {
  double thousandths = 0;  // width in thousandths of the font size
  for (std::size_t i = 0; i < text.size();) {
    const Utf8Character c = characterAt(text, i);
    thousandths += widthOf(c.code);
    i += c.bytes;
  }
  return thousandths / 1000 * fontSize * kOtherFonts * (weight == FontWeight::Bold ? kBold : 1);
}

std::vector<std::string> wrapSvgText(std::string_view text, double fontSize, double width, FontWeight weight) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" \n\t", i), text.size());
    const std::string_view word = text.substr(i, end - i);
    i = end + 1;
    if (word.empty()) continue;
    if (!lines.empty() && svgTextWidth(fmt::format("{} {}", lines.back(), word), fontSize, weight) <= width) {
      lines.back() += fmt::format(" {}", word);
    } else {
      lines.emplace_back(word);
    }
  }
  return lines;
}

std::string shortened(const std::string& text, std::size_t maxCharacters) {
  constexpr std::size_t kLast = 10;  // number of characters that are kept at the end
  std::vector<std::size_t> starts;   // byte at which each character begins
  for (std::size_t i = 0; i < text.size(); i += utf8At(text, i).bytes) starts.push_back(i);
  if (starts.size() <= maxCharacters) return text;
  const std::size_t firstOmitted = starts[maxCharacters - kLast - 1];
  return text.substr(0, firstOmitted) + "\xE2\x80\xA6" + text.substr(starts[starts.size() - kLast]);
}

std::string svgNumber(double value) {
  std::string text = fmt::format("{:.2f}", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace scanmill
