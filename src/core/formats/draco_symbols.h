#pragma once

// An encoder for the entropy coding of Draco's bit stream: the rANS coder of its specification, section "Symbol
// decoding" (https://google.github.io/draco/spec).

#include <cstdint>
#include <span>
#include <string>

namespace scanmill {

// Appends a number as LEB128, which the specification calls varUI32 and varUI64.
void appendVarint(std::uint64_t value, std::string& out);

// Appends `symbols` as Draco's DecodeSymbols() reads them. Each symbol is below 2^31, and `components` (1 or 3)
// successive symbols make one entry. A higher `level` (0 to 10) stores probabilities more precisely and gives fewer
// bytes.
void appendSymbols(std::span<const std::uint32_t> symbols, int components, int level, std::string& out);

}  // namespace scanmill
