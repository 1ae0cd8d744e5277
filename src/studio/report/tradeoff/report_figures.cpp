#include <algorithm>
#include <array>
#include <optional>

#include "methods/method.h"
#include "report/tradeoff/report.h"
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

// The first kMethodColors methods of the table methods() have fixed colours, which are the first ones of the palette.
constexpr std::size_t kMethodColors = 3;
constexpr std::array<std::size_t, 5> kMoreColors{3, 4, 5, 7, 6};

// Returns the fixed colour of a method; nothing if the method is not among the first kMethodColors methods.
std::optional<std::size_t> ownColor(const std::string& method) {
  const MethodEntry* entry = findMethod(method);
  if (entry == nullptr || entry - methods().data() >= static_cast<std::ptrdiff_t>(kMethodColors)) return std::nullopt;
  return static_cast<std::size_t>(entry - methods().data());
}

}  // namespace

std::string placeText(const std::string& group) {
  return group == kAwayFromEdges ? "away from edges" : group == "edges" ? "at edges" : group;
}

std::vector<std::string> groupNames(const Study& study, const std::vector<std::size_t>& settings, Groups groups) {
  std::vector<std::string> names;
  for (const std::size_t i : settings) {
    for (const ErrorGroup& g : study.settings[i].measured.errors.*groups) {
      const bool known = std::ranges::find(names, g.name) != names.end();
      if (g.errors.beams > 0 && !known) names.push_back(g.name);
    }
  }
  return names;
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
  const auto first = [&](std::size_t k) { return std::ranges::find(methods, methods[k]) - methods.begin(); };
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
    if (shown.size() < most && std::ranges::find(shown, i) == shown.end()) shown.push_back(i);
  };
  for (const std::string& method : methodsOf(study)) {
    std::vector<std::size_t> own;
    std::ranges::copy_if(measured, std::back_inserter(own),
                         [&](std::size_t i) { return study.settings[i].setting.method == method; });
    if (own.empty()) continue;
    fastest.push_back(*std::ranges::min_element(own, [&](std::size_t a, std::size_t b) {
      return study.settings[a].measured.cost.scanSeconds < study.settings[b].measured.cost.scanSeconds;
    }));
    const auto byDefault =
        std::ranges::find_if(own, [&](std::size_t i) { return isDefault(study.settings[i].setting); });
    show(byDefault != own.end() ? *byDefault : fastest.back());
  }
  for (const std::size_t i : fastest) show(i);
  for (const std::size_t i : frontOf(study, rangeP99)) show(i);
  for (const std::size_t i : frontOf(study, wrongShare)) show(i);
  return shown;
}

std::vector<std::size_t> settingsByMethod(const Study& study, std::size_t most) {
  std::vector<std::size_t> rows = measuredSettings(study);
  if (rows.size() > most) rows = shownSettings(study, most);
  const std::vector<std::string> methods = methodsOf(study);
  const auto place = [&](std::size_t i) { return std::ranges::find(methods, study.settings[i].setting.method); };
  std::ranges::stable_sort(rows, [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
  return rows;
}

}  // namespace scanmill
