#pragma once

// Formats figures for users.

#include <filesystem>
#include <string>
#include <string_view>

namespace scanmill {

// Returns a number as text with three significant digits, but with all digits before the decimal point and without an
// exponent, such as "0.0123" or "12345".
std::string threeDigits(double value);
std::string metresText(double metres);    // returns a length, such as "0", "46.4 mm" or "1.23 m"
std::string secondsText(double seconds);  // returns a time, such as "350 µs", "2.9 ms" or "1.2 s"
// Returns a fraction in percent, such as "98.4 %" or "99.9991 %"; "100 %" and "0 %" only if exact.
std::string shareText(double share);
std::string factorText(double factor);  // returns a factor, such as "2.1", "27" or "0.35"

std::string lastName(const std::filesystem::path& path);  // returns the name of a file or folder; resolves "."
std::string keyAsWords(std::string_view key);  // returns a key as words, such as "depth camera" for "depth_camera"
std::string today();                           // returns the date in UTC, such as "2026-11-23"

}  // namespace scanmill
