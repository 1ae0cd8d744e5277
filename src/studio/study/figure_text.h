#pragma once

// Figures as text for people: with a unit, and with the significant digits alone.

#include <cstdint>
#include <string>
#include <string_view>

namespace scanmill {

std::string threeDigits(double value);    // "0.0123", "12345"; never an exponent
std::string metresText(double metres);    // "0", "46.4 mm", "1.23 m"
std::string secondsText(double seconds);  // "350 µs", "2.9 ms", "1.2 s"
std::string amountText(double amount);    // "950", "45.3 k", "1.28 M"
std::string shareText(double share);  // "98.4 %", "99.9991 %"; "100 %" and "0 %" only for exactly all and exactly none
std::string factorText(double factor);  // "2.1", "27", "0.35"

std::string wordsOf(std::string_view key);                         // "depth_camera" becomes "depth camera"
std::string pluralOf(std::uint64_t count, std::string_view what);  // "1 scan", "2 scans"

}  // namespace scanmill
