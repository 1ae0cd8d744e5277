#pragma once

// Scans as lines of numbers: what CSV and ASCII PCD share.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
#include "scan/scan.h"

namespace scanmill {

// One line per point, columns in the order of columnNames(), shortest digits that read back to the same bits.
void appendRows(const Scan& scan, char separator, std::string& out);

// Characters of the longest line that a scan with the columns of these names can have.
std::size_t longestRow(std::span<const std::string> names);

// Reads a whole word as a number; throws InputError at `where` naming `column` where it is none or out of range.
void readNumber(std::string_view word, float& value, std::string_view column, const Location& where);
void readNumber(std::string_view word, std::uint16_t& value, std::string_view column, const Location& where);
void readNumber(std::string_view word, std::uint32_t& value, std::string_view column, const Location& where);

}  // namespace scanmill
