#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

#include "base/append_new.h"
#include "methods/method.h"
#include "study/tradeoff/study.h"

namespace scanmill {

const GroupErrors* errorsNamed(const std::vector<ErrorGroup>& groups, std::string_view name) {
  const auto found = std::ranges::find(groups, name, &ErrorGroup::name);
  return found == groups.end() ? nullptr : &found->errors;
}

double wrongShare(const GroupErrors& e) {
  return shareOf(e.bothHit - std::min(e.sameLabel, e.bothHit) + e.falseNegatives + e.falsePositives + e.unresolved,
                 e.beams);
}

double rangeP99(const GroupErrors& e) {
  if (e.range.count == 0) return std::numeric_limits<double>::quiet_NaN();
  return e.range.p99 < kExactRange ? 0 : e.range.p99;
}

double beamsPerSecond(const Study& study, const SettingResult& result) {
  const double seconds = result.measured.cost.scanSeconds;
  return seconds > 0 ? static_cast<double>(study.beamsPerShot) / seconds : 0;
}

bool isDefault(const Setting& setting) {
  return setting.name == setting.method;
}

std::vector<std::size_t> measuredSettings(const Study& study, const std::string& method) {
  std::vector<std::size_t> measured;
  for (std::size_t i = 0; i < study.settings.size(); ++i) {
    const SettingResult& s = study.settings[i];
    if (s.failure.empty() && (method.empty() || s.setting.method == method)) measured.push_back(i);
  }
  return measured;
}

std::optional<std::size_t> tracingDefault(const Study& study) {
  for (const std::size_t i : measuredSettings(study)) {
    const MethodEntry* const entry = findMethod(study.settings[i].setting.method);
    if (entry != nullptr && entry->can.reference && isDefault(study.settings[i].setting)) return i;
  }
  return std::nullopt;
}

std::vector<std::string> methodsOf(const Study& study) {
  std::vector<std::string> methods;
  for (const SettingResult& s : study.settings) appendNew({s.setting.method}, methods);
  return methods;
}

std::vector<std::size_t> frontOf(const Study& study, double (*error)(const GroupErrors&)) {
  // Ratio up to which times on the front count as equal, since repeated measurements often differ by several per cent.
  constexpr double kFrontStep = 1.05;
  const auto secondsOf = [&](std::size_t i) { return study.settings[i].measured.cost.scanSeconds; };
  const auto errorOf = [&](std::size_t i) { return error(study.settings[i].measured.errors.all); };
  std::vector<std::size_t> byTime = measuredSettings(study);
  std::erase_if(byTime, [&](std::size_t i) { return std::isnan(secondsOf(i)) || std::isnan(errorOf(i)); });
  std::ranges::stable_sort(byTime, {}, [&](std::size_t i) { return std::pair(secondsOf(i), errorOf(i)); });
  std::vector<std::size_t> front;  // each setting has a smaller error than all faster ones
  for (const std::size_t i : byTime) {
    if (front.empty() || errorOf(i) < errorOf(front.back())) front.push_back(i);
  }
  std::vector<std::size_t> fromSlowest;  // the front without settings that are hardly faster than a more exact one
  for (const std::size_t i : std::views::reverse(front)) {
    if (fromSlowest.empty() || secondsOf(i) * kFrontStep < secondsOf(fromSlowest.back())) fromSlowest.push_back(i);
  }
  return {fromSlowest.rbegin(), fromSlowest.rend()};
}

}  // namespace scanmill
