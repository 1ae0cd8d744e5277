#pragma once

#include <string>
#include <string_view>

namespace scanmill {

// A PNG reduced to the chunks that make its pixels, every one whole. libpng writes to standard error about damage, and
// about colour profiles, which pixels as stored do not need. Throws InputError that starts with `name`.
std::string plainPng(std::string_view bytes, const std::string& name);

}  // namespace scanmill
