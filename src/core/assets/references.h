#pragma once

// Checks names of files that untrusted files contain.

#include <filesystem>
#include <string>

namespace scanmill {

// True if a name leads out of the folder of the asset that contains the name: it is absolute, or climbs by "..".
// Symbolic links inside of the folder are not checked: they are the responsibility of its owner.
bool leadsOutside(const std::string& name);

// Returns the message about a name that leads outside: the name, and that allow_outside would permit it.
std::string refusalOf(const std::string& name);

}  // namespace scanmill
