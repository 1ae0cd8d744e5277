#include "study/figure_text.h"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <initializer_list>
#include <utility>

namespace scanmill {

namespace {

// Formats `value` in the largest unit in which it is at least 1 after rounding (0.9995 becomes 1.00), or else in the
// smallest unit. `units`: size and name of each unit, the largest first.
std::string withUnit(double value, std::initializer_list<std::pair<double, const char*>> units) {
  std::string text;
  for (const auto& [size, unit] : units) {
    text = threeDigits(value / size) + unit;
    if (std::abs(value) >= size * 0.9995) break;
  }
  return text;
}

}  // namespace

std::string threeDigits(double value) {
  if (!std::isfinite(value)) return std::isnan(value) ? "unknown" : "unlimited";
  if (value == 0) return "0";
  const int digitsBeforePoint = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;  // negative below 0.1
  std::string text = fmt::format("{:.{}f}", value, std::clamp(3 - digitsBeforePoint, 0, 9));
  if (text.find('.') == std::string::npos) return text;
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string metresText(double metres) {
  if (metres == 0) return "0";
  if (metres < 1e-6) return "< 1 \xC2\xB5m";
  return withUnit(metres, {{1e3, " km"}, {1, " m"}, {1e-3, " mm"}, {1e-6, " \xC2\xB5m"}});
}

std::string secondsText(double seconds) {
  if (seconds == 0) return "0 s";
  return withUnit(seconds, {{1, " s"}, {1e-3, " ms"}, {1e-6, " \xC2\xB5s"}});
}

std::string shareText(double share) {
  if (!std::isfinite(share)) return "unknown";
  const double percentFromEnd = std::min(share, 1 - share) * 100;  // distance from 0 or 100 %, whichever is nearer
  if (percentFromEnd <= 0) return fmt::format("{:.0f} %", share * 100);
  if (percentFromEnd < 1e-5) return share < 0.5 ? "below 0.00001 %" : "above 99.99999 %";
  // Show two significant digits of the difference from 0 or 100 %, whichever is nearer.
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(percentFromEnd))), 1, 6);
  return fmt::format("{:.{}f} %", share * 100, decimals);
}

std::string factorText(double factor) {
  if (!std::isfinite(factor)) return "unknown";
  if (factor >= 10) return fmt::format("{:.0f}", factor);
  return fmt::format("{:.{}f}", factor, factor >= 0.995 ? 1 : 2);
}

std::string lastName(const std::filesystem::path& path) {
  const std::filesystem::path full = std::filesystem::absolute(path).lexically_normal();
  return (full.has_filename() ? full : full.parent_path()).filename().string();
}

std::string keyAsWords(std::string_view key) {
  std::string words(key);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string today() {
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr)));
}

}  // namespace scanmill
