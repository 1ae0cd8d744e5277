#pragma once

// Entropy coding of Draco's bit stream: the rANS coder of its specification, section "Symbol decoding"
// (https://google.github.io/draco/spec), as an encoder.

#include <cstdint>
#include <span>
#include <string>

namespace scanmill {

// Appends a number as LEB128, which the specification calls varUI32 and varUI64.
void appendVarint(std::uint64_t value, std::string& out);

// Appends what Draco's DecodeSymbols() reads back as `symbols`. Each symbol is below 2^31, and 1 or 3 of them, as
// `components` says, make one entry. A higher `level` (0 to 10) stores probabilities more precisely and gives fewer
// bytes.
void appendSymbols(std::span<const std::uint32_t> symbols, int components, int level, std::string& out);

}  // namespace scanmill
