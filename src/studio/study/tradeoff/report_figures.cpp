#include "study/tradeoff/report_figures.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "methods/method.h"

namespace scanmill {

namespace {

// Three significant digits, never an exponent.
std::string threeDigits(double value) {
  if (!std::isfinite(value)) return std::isnan(value) ? "unknown" : "unlimited";
  const double size = std::abs(value);
  if (size == 0) return "0";
  const int before = static_cast<int>(std::floor(std::log10(size))) + 1;
  std::string text = fmt::format("{:.{}f}", value, std::clamp(3 - before, 0, 9));
  if (text.find('.') == std::string::npos) return text;
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

struct Scale {
  double factor;
  const char* unit;
};

// The largest scale that leaves at least 1 (0.9995 becomes 1.00), or the smallest scale.
template <std::size_t n>
std::string scaled(double value, const std::array<Scale, n>& scales) {
  for (const Scale& scale : scales) {
    if (std::abs(value) >= scale.factor * 0.9995) return threeDigits(value / scale.factor) + scale.unit;
  }
  return threeDigits(value / scales.back().factor) + scales.back().unit;
}

constexpr double kFrontStep = 1.05;                      // of times
constexpr std::string_view kAwayFromEdges = "interior";  // as the study's files call it
constexpr std::size_t kMethodColors = 3;  // the chart's first ones are those of the first rows of methods()
constexpr std::array<std::size_t, 5> kMoreColors{3, 4, 5, 7, 6};

// Which of kMethodColors a method has; none where it has none of them.
std::optional<std::size_t> ownColor(const std::string& method) {
  const MethodEntry* entry = findMethod(method);
  if (entry == nullptr || entry - methods().data() >= static_cast<std::ptrdiff_t>(kMethodColors)) return std::nullopt;
  return static_cast<std::size_t>(entry - methods().data());
}

std::vector<std::size_t> frontOf(const Study& study, double (*error)(const GroupErrors&)) {
  const std::vector<std::size_t> measured = measuredSettings(study);
  std::vector<double> seconds, errors;
  for (const std::size_t i : measured) {
    seconds.push_back(study.settings[i].measured.cost.scanSeconds);
    errors.push_back(error(study.settings[i].measured.errors.all));
  }
  std::vector<std::size_t> whole = paretoFront(seconds, errors);
  std::reverse(whole.begin(), whole.end());
  std::vector<std::size_t> front;
  double last = std::numeric_limits<double>::infinity();
  for (const std::size_t i : whole) {
    if (seconds[i] * kFrontStep >= last) continue;
    last = seconds[i];
    front.push_back(measured[i]);
  }
  std::reverse(front.begin(), front.end());
  return front;
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

std::string metresText(double metres) {
  if (metres == 0) return "0";
  if (metres < 1e-6) return "< 1 \xC2\xB5m";
  return scaled(metres, std::array<Scale, 4>{{{1e3, " km"}, {1, " m"}, {1e-3, " mm"}, {1e-6, " \xC2\xB5m"}}});
}

std::string secondsText(double seconds) {
  if (seconds == 0) return "0 s";
  return scaled(seconds, std::array<Scale, 3>{{{1, " s"}, {1e-3, " ms"}, {1e-6, " \xC2\xB5s"}}});
}

std::string amountText(double amount) {
  if (amount < 1) return threeDigits(amount);
  return scaled(amount, std::array<Scale, 4>{{{1e9, " G"}, {1e6, " M"}, {1e3, " k"}, {1, ""}}});
}

std::string shareText(double value) {
  if (!std::isfinite(value)) return "unknown";
  const double fromEnd = std::min(value, 1 - value) * 100;
  if (fromEnd <= 0) return fmt::format("{:.0f} %", value * 100);
  if (fromEnd < 1e-5) return value < 0.5 ? "below 0.00001 %" : "above 99.99999 %";
  // Two digits of what is missing to 0 or to 100.
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(fromEnd))), 1, 6);
  return fmt::format("{:.{}f} %", value * 100, decimals);
}

std::string factorText(double factor) {
  if (!std::isfinite(factor)) return "unknown";
  if (factor >= 10) return fmt::format("{:.0f}", factor);
  return fmt::format("{:.{}f}", factor, factor >= 0.995 ? 1 : 2);
}

std::string wordsOf(std::string_view key) {
  std::string words(key);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string pluralOf(std::uint64_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string placeText(const std::string& group) {
  return group == kAwayFromEdges ? "away from edges" : group == "edges" ? "at edges" : group;
}

const GroupErrors* awayFromEdges(const BeamErrors& errors) {
  for (const ErrorGroup& group : errors.byPlace) {
    if (group.name == kAwayFromEdges) return &group.errors;
  }
  return nullptr;
}

double wrongShare(const GroupErrors& e) {
  return share(e.bothHit - std::min(e.sameLabel, e.bothHit) + e.lost + e.spurious + e.unresolved, e.beams);
}

double lostShare(const GroupErrors& e) {
  return share(e.lost, e.bothHit + e.lost);
}

double rangeP99(const GroupErrors& e) {
  if (e.range.count == 0) return std::numeric_limits<double>::quiet_NaN();
  return e.range.p99 < kExactRange ? 0 : e.range.p99;
}

double nearestMean(const GroupErrors& e) {
  if (e.nearestTo.count == 0) return std::numeric_limits<double>::quiet_NaN();
  return e.nearestTo.mean < kExactRange ? 0 : e.nearestTo.mean;
}

double beamsPerSecond(const Study& study, const SettingResult& result) {
  return result.measured.cost.beamsPerSecond(study.beamsPerShot);
}

bool isDefault(const Setting& setting) {
  return setting.name == setting.method;
}

std::string setArgument(const Setting& setting) {
  std::string quoted;
  for (const char c : setting.assignment()) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return fmt::format("--set '{}'", quoted);
}

std::vector<std::size_t> measuredSettings(const Study& study) {
  std::vector<std::size_t> measured;
  for (std::size_t i = 0; i < study.settings.size(); ++i) {
    if (study.settings[i].failure.empty()) measured.push_back(i);
  }
  return measured;
}

std::optional<std::size_t> tracingDefault(const Study& study) {
  for (const std::size_t i : measuredSettings(study)) {
    const MethodEntry* entry = findMethod(study.settings[i].setting.method);
    if (entry != nullptr && entry->can.reference && isDefault(study.settings[i].setting)) return i;
  }
  return std::nullopt;
}

std::vector<std::string> methodsOf(const Study& study) {
  std::vector<std::string> methods;
  for (const SettingResult& s : study.settings) {
    if (std::find(methods.begin(), methods.end(), s.setting.method) == methods.end()) {
      methods.push_back(s.setting.method);
    }
  }
  return methods;
}

std::vector<std::size_t> rangeFront(const Study& study) {
  return frontOf(study, rangeP99);
}
std::vector<std::size_t> wrongFront(const Study& study) {
  return frontOf(study, wrongShare);
}

std::size_t methodColor(const Study& study, const std::string& method) {
  if (const std::optional<std::size_t> own = ownColor(method)) return *own;
  std::size_t others = 0;
  for (const std::string& other : methodsOf(study)) {
    if (other == method) break;
    others += ownColor(other) ? 0 : 1;
  }
  return kMoreColors[others % 3];
}

std::vector<std::size_t> settingColors(const Study& study, const std::vector<std::string>& methods) {
  const auto first = [&](std::size_t k) {
    return std::find(methods.begin(), methods.end(), methods[k]) - methods.begin();
  };
  std::vector<std::size_t> colors(methods.size());
  std::vector<std::size_t> free(kMoreColors.begin(), kMoreColors.end());
  for (std::size_t k = 0; k < methods.size(); ++k) {
    if (static_cast<std::size_t>(first(k)) != k) continue;
    colors[k] = methodColor(study, methods[k]);
    std::erase(free, colors[k]);
  }
  std::size_t more = 0;
  for (std::size_t k = 0; k < methods.size(); ++k) {
    if (static_cast<std::size_t>(first(k)) != k && !free.empty()) colors[k] = free[more++ % free.size()];
  }
  return colors;
}

std::vector<std::size_t> shownSettings(const Study& study, std::size_t most) {
  const std::vector<std::size_t> measured = measuredSettings(study);
  std::vector<std::size_t> shown, fastest;
  const auto show = [&](std::size_t i) {
    if (shown.size() < most && std::find(shown.begin(), shown.end(), i) == shown.end()) shown.push_back(i);
  };
  for (const std::string& method : methodsOf(study)) {
    std::vector<std::size_t> own;
    std::copy_if(measured.begin(), measured.end(), std::back_inserter(own),
                 [&](std::size_t i) { return study.settings[i].setting.method == method; });
    if (own.empty()) continue;
    fastest.push_back(*std::min_element(own.begin(), own.end(), [&](std::size_t a, std::size_t b) {
      return study.settings[a].measured.cost.scanSeconds < study.settings[b].measured.cost.scanSeconds;
    }));
    const auto byDefault =
        std::find_if(own.begin(), own.end(), [&](std::size_t i) { return isDefault(study.settings[i].setting); });
    show(byDefault != own.end() ? *byDefault : fastest.back());
  }
  for (const std::size_t i : fastest) show(i);
  for (const std::size_t i : rangeFront(study)) show(i);
  for (const std::size_t i : wrongFront(study)) show(i);
  return shown;
}

std::vector<std::size_t> settingsByMethod(const Study& study, std::size_t most) {
  std::vector<std::size_t> rows = measuredSettings(study);
  if (rows.size() > most) rows = shownSettings(study, most);
  const std::vector<std::string> methods = methodsOf(study);
  const auto place = [&](std::size_t i) {
    return std::find(methods.begin(), methods.end(), study.settings[i].setting.method);
  };
  std::stable_sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
  return rows;
}

}  // namespace scanmill
