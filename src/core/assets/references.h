#pragma once

// Names of files in files of strangers.

#include <filesystem>
#include <string>

namespace scanmill {

// Whether a name leads out of the folder of the asset that holds it: it is absolute, or climbs by "..". Links within
// the folder are their owner's business.
bool leadsOutside(const std::string& name);

// What to say of such a name: what it names, and that allow_outside would let it.
std::string refusalOf(const std::string& name);

}  // namespace scanmill
