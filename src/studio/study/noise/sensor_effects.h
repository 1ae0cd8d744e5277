#pragma once

// Writes effects into a sensor file.

#include <string>

namespace scanmill {

// The text of a sensor file with `effects`, lines that begin with "effects:", in place of its own effects, or at its
// end where it has none. Everything else stays, comments too. `file` names the text in errors. Throws InputError where
// the text is no sensor file, or one in flow style ({...}), whose keys have no lines of their own.
std::string withEffects(const std::string& text, const std::string& file, const std::string& effects);

}  // namespace scanmill
