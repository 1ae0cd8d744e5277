#pragma once

// Entropy coding of Draco's bit stream: the rANS coder of its specification, section "Symbol decoding"
// (https://google.github.io/draco/spec), as an encoder.

#include <cstdint>
#include <span>
#include <string>

namespace scanmill {

// Appends LEB128, Draco's varUI32 and varUI64.
void appendVarint(std::uint64_t value, std::string& out);

// Appends what Draco's DecodeSymbols() reads back as `symbols`, which are below 2^31. `components` of them, 1 or 3,
// make one entry. A higher level (0 to 10) gives fewer bytes; it changes the precision of the probabilities.
void appendSymbols(std::span<const std::uint32_t> symbols, int components, int level, std::string& out);

}  // namespace scanmill
