#pragma once

// Scans as lines of numbers: what CSV and ASCII PCD share.

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.h"
#include "scan/scan.h"

namespace scanmill {

// One line per point, columns in the order of columnNames(), shortest digits that read back to the same bits.
void appendRows(const Scan& scan, char separator, std::string& out);

// Characters of the longest line that a scan with these columns of the table can have.
std::size_t longestRow(ColumnSet columns);

// Reads a whole word as a number of any type that a column may have; throws InputError at `where` naming `column` where
// it is none or out of range.
template <class T>
void readNumber(std::string_view word, T& value, std::string_view column, const Location& where);

}  // namespace scanmill
