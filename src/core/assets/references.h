#pragma once

// Checks names of files that untrusted files contain.

#include <filesystem>
#include <string>

namespace scanmill {

// True if a name leads out of the folder of the asset that contains the name: the name is absolute, or climbs by "..".
// Symbolic links inside of the folder are not checked: the folder's owner is responsible for them.
bool leadsOutside(const std::string& name);

// Returns the message about a name that leads outside: it contains the name, and says how to allow it by allow_outside.
std::string refusalOf(const std::string& name);

}  // namespace scanmill
