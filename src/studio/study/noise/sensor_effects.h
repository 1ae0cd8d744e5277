#pragma once

// Writes effects into a sensor file.

#include <string>

namespace scanmill {

// The text of a sensor file with `effects`, lines that begin with "effects:", in place of those of its own effects that
// are noise (dropout, range_noise, shell, quantize, and ring_bias where the new ones have it), or at its end where it
// has no effects. Everything else stays, comments too, and effects such as intensity or footprint stand before the
// new ones. `file` names the text in errors. Throws InputError where
// the text is no sensor file, or one in flow style ({...}), whose keys have no lines of their own.
std::string withEffects(const std::string& text, const std::string& file, const std::string& effects);

}  // namespace scanmill
