#pragma once

// Writes effects into a sensor file.

#include <string>

namespace scanmill {

// Returns the text of a sensor file with `effects` (lines that begin with "effects:"). These replace the file's own
// noise effects (dropout, range_noise, shell, quantize, and also ring_bias if `effects` has it), or stand at the end if
// the file has no effects. Everything else stays, including comments; other effects such as intensity or footprint come
// before the new ones. `file` names the text in errors. Throws InputError if the text is not a sensor file, or is one
// in flow style ({...}), whose keys have no lines of their own.
std::string withEffects(const std::string& text, const std::string& file, const std::string& effects);

}  // namespace scanmill
