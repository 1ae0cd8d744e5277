#pragma once

// Measures, breaks and escapes text for SVG and HTML.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Returns text that may stand between tags, or in a quoted attribute, of XML and HTML. Characters that XML cannot hold
// (control characters, bytes that are not UTF-8) become U+FFFD.
std::string escapeXml(std::string_view text);

// Returns the approximate width of text in pixels: Helvetica's widths, plus a little for wider substitute fonts.
double svgTextWidth(std::string_view text, double fontSize, bool bold = false);

// Breaks text between words into lines of at most `width` pixels; a longer word has its own line. An empty text has no
// lines.
std::vector<std::string> wrapSvgText(std::string_view text, double fontSize, double width, bool bold = false);

// Writes a number with at most two decimals, without trailing zeros.
std::string svgNumber(double value);

}  // namespace scanmill
