#include "evaluate/settings.h"

#include <fmt/core.h>

#include <algorithm>

#include "config/fields.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostSettings = 500;  // maximum number of settings; more would take days

}  // namespace

std::vector<Value> expandLists(const Value& options, const std::string& what) {
  std::vector<Value> combinations{options};
  for (std::size_t e = 0; e < options.entries.size(); ++e) {
    const Value& list = options.entries[e].value;
    if (list.kind != Value::Kind::Sequence) continue;
    if (list.items.empty()) throw InputError(list.where, "{}: the list is empty", what);
    std::vector<Value> expanded;  // each combination of the previous lists, with each item of this list
    for (const Value& combination : combinations) {
      for (const Value& item : list.items) {
        expanded.push_back(combination);
        expanded.back().entries[e].value = item;
      }
    }
    combinations = std::move(expanded);
    if (combinations.size() > kMostSettings) {
      throw InputError(list.where, "{}: these lists expand to more than {} settings", what, kMostSettings);
    }
  }
  return combinations;
}

std::string settingName(const std::string& method, const Value& options) {
  std::string name = method;
  for (const Value::Entry& entry : options.entries) name += fmt::format(" {}={}", entry.key, flowText(entry.value));
  return name;
}

std::string Setting::assignment() const {
  return options == "{}" ? fmt::format("method={}", method) : fmt::format("method={{{}: {}}}", method, options);
}

std::vector<MethodSetting> readSettings(const Value& list, const std::string& what) {
  std::vector<MethodSetting> settings;
  const Scene emptyScene;  // methods are created with this scene to check their options
  for (const Value& item : readList(list, what)) {
    const NamedOptions named = readNamed(item, "an item of " + what);
    const MethodEntry& entry = requireMethod(named.name, named.where);
    for (const Value& options : expandLists(named.options, what)) {
      Fields fields(options, "method " + named.name);
      fields.alsoDescribed(entry.keys).finish();
      entry.make(emptyScene, fields);
      MethodSetting setting{{settingName(named.name, options), named.name, flowText(options)}, {&entry, options}};
      const auto isListed = [&](const MethodSetting& s) { return s.setting.name == setting.setting.name; };
      if (std::ranges::any_of(settings, isListed)) {
        throw InputError(item.where, "{}: '{}' is listed twice", what, setting.setting.name);
      }
      settings.push_back(std::move(setting));
      if (settings.size() > kMostSettings) {
        throw InputError(item.where, "{}: the list has more than {} settings", what, kMostSettings);
      }
    }
  }
  return settings;
}

}  // namespace scanmill
