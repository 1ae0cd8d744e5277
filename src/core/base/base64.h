#pragma once

// Base64: bytes as text (RFC 4648, section 4).

#include <optional>
#include <string>
#include <string_view>

namespace scanmill {

std::string base64(std::string_view bytes);
// Returns the bytes that the text encodes; nullopt if the text is not base64. Padding at the end may be left out.
std::optional<std::string> fromBase64(std::string_view text);

}  // namespace scanmill
