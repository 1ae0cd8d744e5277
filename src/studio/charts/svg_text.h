#pragma once

// Measures, breaks and escapes text for SVG and HTML.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Text that may stand between the tags, or in a quoted attribute, of XML and HTML. What XML cannot hold (control
// characters, bytes that are not UTF-8) becomes U+FFFD.
std::string escapeXml(std::string_view text);

// The approximate width of text in pixels: by Helvetica's widths, and a little for the wider fonts that stand in for
// it.
double svgTextWidth(std::string_view text, double fontSize, bool bold = false);

// Breaks text between words into lines of at most `width` pixels; a longer word has a line of its own. An empty text
// has no lines.
std::vector<std::string> wrapSvgText(std::string_view text, double fontSize, double width, bool bold = false);

// A number with at most two decimals, without trailing zeros.
std::string svgNumber(double value);

}  // namespace scanmill
