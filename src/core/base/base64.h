#pragma once

// Bytes as text (RFC 4648, section 4).

#include <optional>
#include <string>
#include <string_view>

namespace scanmill {

std::string base64(std::string_view bytes);
// Nothing where the text is not base64. Padding at the end may be left out.
std::optional<std::string> fromBase64(std::string_view text);

}  // namespace scanmill
