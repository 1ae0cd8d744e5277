#pragma once

#include <string>
#include <string_view>

namespace scanmill {

// Decodes the escapes of a URI: "%2F" becomes "/". What is no escape stays as it is.
std::string decodeUri(std::string_view uri);

}  // namespace scanmill
