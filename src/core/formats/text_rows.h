#pragma once

// Writes scans as lines of numbers and reads numbers, for CSV and ASCII PCD.

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.h"
#include "scan/scan.h"

namespace scanmill {

// Appends one line per point, with columns in the order of columnNames(). Numbers have the fewest digits that read back
// to the same bits.
void appendRows(const Scan& scan, char separator, std::string& out);

// Returns an upper bound of the characters in a line of a scan with these columns.
std::size_t longestRow(ColumnSet columns);

// Reads the complete `word` as a number of type T, which may be any type of a column. Throws an InputError at `where`
// that names `column` if the word is not a number or T cannot represent it.
template <class T>
void readNumber(std::string_view word, T& value, std::string_view column, const Location& where);

}  // namespace scanmill
