#pragma once

#include <string>
#include <string_view>

namespace scanmill {

// Decodes the escapes of a URI: "%2F" becomes "/". All other text is unchanged.
std::string decodeUri(std::string_view uri);

}  // namespace scanmill
