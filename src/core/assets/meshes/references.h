#pragma once

// Checks the names of other files that an asset's file contains. The asset may be untrusted.

#include <filesystem>
#include <string>
#include <string_view>

namespace scanmill {

// True if a name leads out of the folder of the asset that contains the name: the name is absolute, or climbs by "..".
// Symbolic links inside of the folder are not checked: the folder's owner is responsible for them.
bool leadsOutside(const std::string& name);

// Returns the message about a name that leads outside: it contains the name, and says how to allow it by allow_outside.
std::string refusalOf(const std::string& name);

// Decodes the escapes of a URI: "%2F" becomes "/". All other text is unchanged.
std::string decodeUri(std::string_view uri);

}  // namespace scanmill
