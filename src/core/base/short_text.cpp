#include "base/short_text.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scanmill {

std::string shortNumber(double value) {
  for (const auto& [scale, suffix] : {std::pair{1e12, " T"}, {1e9, " G"}, {1e6, " M"}, {1e3, " k"}}) {
    if (std::abs(value) >= scale * 0.9995) return fmt::format("{:.3g}{}", value / scale, suffix);
  }
  return fmt::format("{:.3g}", value);
}

std::string pluralOf(std::uint64_t count, std::string_view noun) {
  return fmt::format("{} {}{}", grouped(count), noun, count == 1 ? "" : "s");
}

std::string shortBytes(double bytes) {
  const std::pair<double, const char*> units[] = {
      {1024.0 * 1024 * 1024 * 1024, "TiB"}, {1024.0 * 1024 * 1024, "GiB"}, {1024.0 * 1024, "MiB"}, {1024.0, "KiB"}};
  for (const auto& [scale, suffix] : units) {
    if (bytes >= scale) return fmt::format("{:.1f} {}", bytes / scale, suffix);
  }
  return fmt::format("{:.0f} B", bytes);
}

std::string shortTime(double seconds) {
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const auto wholeSeconds = static_cast<long>(std::min(seconds, 1e12));
  if (wholeSeconds < 3600) return fmt::format("{} min {} s", wholeSeconds / 60, wholeSeconds % 60);
  return fmt::format("{} h {} min", wholeSeconds / 3600, wholeSeconds / 60 % 60);
}

std::string shortLength(double metres) {
  const double length = std::abs(metres);
  if (length < 1e3) return fmt::format("{:.4g} m", metres);
  return length < 1e6 ? fmt::format("{:.3g} km", metres / 1e3) : fmt::format("{:.0f} km", metres / 1e3);
}

std::string shortPosition(const Vec3d& point) {
  return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", point.x, point.y, point.z);
}

std::string extentText(const Box& box) {
  if (box.empty()) return "-";
  const auto edge = [](double m) { return m >= 100 ? fmt::format("{:.0f}", m) : fmt::format("{:.3g}", m); };
  const Vec3d size = box.high - box.low;
  return fmt::format("{} x {} x {} m", edge(size.x), edge(size.y), edge(size.z));
}

namespace {

constexpr std::pair<double, const char*> kSiPrefixes[]{{1e12, "T"},        {1e9, "G"},  {1e6, "M"},
                                                       {1e3, "k"},         {1.0, ""},   {1e-3, "m"},
                                                       {1e-6, "\xC2\xB5"}, {1e-9, "n"}, {1e-12, "p"}};

// Returns a number with up to six significant digits. Exponents have no leading zero.
std::string plainNumber(double value) {
  std::string text = fmt::format("{:.6g}", value);
  if (const std::size_t e = text.find("e-0"); e != std::string::npos) text.erase(e + 2, 1);
  return text;
}

}  // namespace

double niceStep(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::string shortList(const std::vector<std::string>& texts, std::size_t most) {
  const std::size_t shown = std::min(texts.size(), most);
  const std::string list = fmt::format("{}", fmt::join(texts.begin(), texts.begin() + std::ptrdiff_t(shown), ", "));
  return shown < texts.size() ? fmt::format("{} and {} more", list, texts.size() - shown) : list;
}

std::string axisNumber(double value, const std::string& unit) {
  if (unit == "%") return plainNumber(value * 100) + " %";
  const double magnitude = std::abs(value);
  const std::string space = unit.empty() ? "" : " ";
  if (magnitude == 0) return "0" + space + unit;
  constexpr double kExponentFrom = 1e16;  // numbers from here on are shorter with an exponent than with a prefix
  const bool readsAsUnit = magnitude < 1 && unit.empty();  // "5 m" for 0.005 would read as 5 metres
  if (!readsAsUnit && magnitude < kExponentFrom) {
    for (const auto& [factor, prefix] : kSiPrefixes) {
      if (magnitude < factor * (1 - 1e-9)) continue;
      const std::string unitText = prefix + unit;
      return plainNumber(value / factor) + (unitText.empty() ? "" : " " + unitText);
    }
  }
  return plainNumber(value) + space + unit;
}

}  // namespace scanmill
