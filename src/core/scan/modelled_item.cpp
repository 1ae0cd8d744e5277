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
  return fmt::format("{}{}{}: {}{}{}", item.topic, sensor, item.options.empty() ? "" : " " + item.options,
                     item.leftOut ? std::string("left out") + gap : "", item.text, parts);
}

namespace {

// Returns all fields except the scenes and parts. addItems() joins items in which these fields are equal.
auto fieldsOfAnyScene(const ModelledItem& item) {
  return std::tie(item.topic, item.text, item.leftOut, item.sensor, item.options);
}

}  // namespace

void addItems(const std::vector<ModelledItem>& added, std::vector<ModelledItem>& items) {
  for (const ModelledItem& item : added) {
    const auto listed = std::ranges::find(items, fieldsOfAnyScene(item), fieldsOfAnyScene);
    if (listed == items.end()) {
      items.push_back(item);
      continue;
    }
    listed->parts = std::max(listed->parts, item.parts);
    if (item.scenes.empty()) {  // the item is about all scenes
      listed->scenes.clear();
    } else if (!listed->scenes.empty()) {
      appendNew(item.scenes, listed->scenes);
    }
  }
}

}  // namespace scanmill
