// The legends of the views, and the messages of views that show nothing.

#include <fmt/core.h>

#include <algorithm>

#include "base/grouped.h"
#include "viewer/color_map.h"
#include "viewer/window/panels.h"

namespace scanmill {

namespace {

bool isOfClasses(const Legend& legend) {
  return !legend.entries.empty() &&
         std::ranges::all_of(legend.entries, [](const LegendEntry& entry) { return entry.id >= 0; });
}

bool meansTheSame(const Legend& a, const Legend& b) {
  if (a.title != b.title) return false;
  if (a.scale || b.scale) {
    return a.scale == b.scale && a.low == b.low && a.high == b.high && a.power == b.power && a.held == b.held;
  }
  return isOfClasses(a) && isOfClasses(b);
}

LegendEntry* entryOf(Legend& legend, std::int64_t id) {
  const auto found = std::ranges::find(legend.entries, id, &LegendEntry::id);
  return found == legend.entries.end() ? nullptr : &*found;
}

}  // namespace

// Adds the classes that occur in other frames to a legend, so that its rows are the same in all frames.
void Panels::completeClasses(Legend& legend) const {
  if (!isOfClasses(legend)) return;
  for (const std::uint16_t id : clouds_.presentClasses) {
    if (entryOf(legend, id) != nullptr) continue;
    legend.entries.push_back(
        {className(context_.source->ontology(), id), classColor(context_.source->ontology(), id), id, 0});
  }
  std::ranges::sort(legend.entries, {}, &LegendEntry::id);
}

// Collects the legends of all views. Views whose colours have the same meaning share one legend, which has the numbers
// of points in the active view; they are 0 if none of these views is active.
void Panels::collectLegends() {
  legends.clear();
  for (std::size_t v = 0; v < panes.size() && context_.options.legends; ++v) {
    const Legend& own = panes[v].legend;
    if (!own.scale && own.entries.empty()) continue;
    const auto same =
        std::ranges::find_if(legends, [&](const LegendBlock& block) { return meansTheSame(block.legend, own); });
    if (same == legends.end()) {
      legends.push_back({own, {v}});
      continue;
    }
    same->views.push_back(v);
    same->legend.unknown += own.unknown;
    for (const LegendEntry& entry : own.entries) {
      if (entryOf(same->legend, entry.id) == nullptr) same->legend.entries.push_back(entry);
    }
  }
  for (auto& [legend, shownIn] : legends) {
    if (shownIn.size() < 2) continue;
    Legend active;
    if (clouds_.activeView && std::ranges::find(shownIn, *clouds_.activeView) != shownIn.end()) {
      active = panes[*clouds_.activeView].legend;
      legend.unknown = active.unknown;
    }
    for (LegendEntry& entry : legend.entries) {
      const LegendEntry* const counted = entryOf(active, entry.id);
      entry.points = counted == nullptr ? 0 : counted->points;
    }
    if (!legend.scale) std::ranges::sort(legend.entries, {}, &LegendEntry::id);
  }
}

bool Panels::isHidden(const LegendEntry& entry) const {
  if (entry.id < 0) return false;
  if (clouds_.overlaid())
    return context_.filter.hiddenScans.contains(context_.frame->scans[static_cast<std::size_t>(entry.id)].name);
  return !context_.filter.classes.shows(static_cast<std::uint16_t>(entry.id));
}

// Sets the messages of views that show nothing.
void Panels::addMessages() {
  if (!context_.frame || context_.source->isScene()) return;
  if (context_.frame->scans.empty()) {
    std::string& message = panes.front().message;
    message = context_.frame->key + " cannot be shown";
    for (const std::string& problem : context_.frame->problems) message += "\n" + problem;
    return;
  }
  for (std::size_t v = 0; v < panes.size(); ++v) {
    std::uint64_t finite = 0;
    std::uint64_t visible = 0;
    for (const ShownCloud& cloud : clouds_.list) {
      if (cloud.view != v) continue;
      finite += cloud.finite;
      visible += cloud.visible;
    }
    if (visible > 0) continue;
    std::string& message = panes[v].message;
    message = finite == 0 ? "no points: the scan is empty"
                          : fmt::format("no point is shown: the filter hides all {}", grouped(finite));
    if (finite > 0 && !context_.options.still) message += "\nA shows them";
  }
}

}  // namespace scanmill
