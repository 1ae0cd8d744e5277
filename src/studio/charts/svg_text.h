#pragma once

// Measures, wraps and escapes text for SVG and HTML.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Returns text that is safe between tags and in quoted attributes of XML and HTML. Characters that XML does not allow,
// and invisible control characters (isUnseenControl()), are replaced by U+FFFD.
std::string escapeXml(std::string_view text);

enum class FontWeight { Normal, Bold };

// Returns the width (pixels) of a text, estimated from Helvetica with a margin for wider fonts in its place.
double svgTextWidth(std::string_view text, double fontSize, FontWeight weight = FontWeight::Normal);

// Breaks text between words into lines of at most `width` pixels. A word wider than `width` gets a line of its own.
// Returns no lines for an empty text.
std::vector<std::string> wrapSvgText(std::string_view text, double fontSize, double width,
                                     FontWeight weight = FontWeight::Normal);

// Returns the text; if it has more than `maxCharacters` characters (at least 11), an ellipsis replaces characters in
// the middle, since names often differ only at their ends.
std::string shortened(const std::string& text, std::size_t maxCharacters);

// Formats a number with at most two decimals, without trailing zeros.
std::string svgNumber(double value);

}  // namespace scanmill
