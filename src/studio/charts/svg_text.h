#pragma once

// Text in SVG and HTML.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// As text or in a quoted attribute of XML and HTML. What XML cannot hold (control characters, bytes that are not UTF-8)
// becomes U+FFFD.
std::string escapeXml(std::string_view text);

// About how wide text is in pixels: Helvetica's widths, and a little for the wider fonts that stand in for it.
double svgTextWidth(std::string_view text, double fontSize, bool bold = false);

// Lines of at most `width` pixels, broken between words; a longer word has a line of its own. None of an empty text.
std::vector<std::string> wrapSvgText(std::string_view text, double fontSize, double width, bool bold = false);

// The text, or as much of its beginning as fits into `width` pixels with an ellipsis.
std::string fitSvgText(std::string_view text, double fontSize, double width);

// Two decimals, without trailing zeros.
std::string svgNumber(double value);

}  // namespace scanmill
