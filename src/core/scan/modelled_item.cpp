#include "scan/modelled_item.h"

#include <fmt/core.h>

#include <algorithm>
#include <tuple>

#include "base/append_new.h"

namespace scanmill {

std::string lineOf(const ModelledItem& item) {
  const std::string sensor = item.sensor.empty() ? "" : fmt::format(" of '{}'", item.sensor);
  const char* const gap = item.text.empty() ? "" : item.text.starts_with('(') ? " " : ", ";
  const std::string parts = item.parts == 0 ? "" : fmt::format(" ({} in a scene)", item.parts);
  return fmt::format("{}{}{}{}{}{}{}", item.topic, sensor, item.options.empty() ? "" : " " + item.options,
                     item.topic.empty() ? "" : ": ", item.leftOut ? std::string("left out") + gap : "", item.text,
                     parts);
}

namespace {

// Returns the fields that are equal in items of several scenes which are listed as one.
auto ofAnyScene(const ModelledItem& item) {
  return std::tie(item.topic, item.text, item.leftOut, item.sensor, item.options);
}

}  // namespace

void addItems(const std::vector<ModelledItem>& more, std::vector<ModelledItem>& items) {
  for (const ModelledItem& item : more) {
    const auto known = std::find_if(items.begin(), items.end(),
                                    [&](const ModelledItem& other) { return ofAnyScene(other) == ofAnyScene(item); });
    if (known == items.end()) {
      items.push_back(item);
      continue;
    }
    known->parts = std::max(known->parts, item.parts);
    if (item.scenes.empty()) {
      known->scenes.clear();
    } else if (!known->scenes.empty()) {
      appendNew(item.scenes, known->scenes);
    }
  }
}

}  // namespace scanmill
