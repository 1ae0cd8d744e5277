#include "viewer/window/session_context.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <map>

#include "base/error.h"
#include "scene/thing_boxes.h"
#include "viewer/color_map.h"

namespace scanmill {

void SessionContext::notify(const std::string& text, double seconds) {
  // A notice that a key causes replaces older notices of the same key.
  std::erase_if(notices, [&](const ViewNotice& n) { return n.text == text || (acting && n.cause == acting); });
  notices.push_back({text, redraw.now() + seconds, acting});
  changes.panels = true;
}

void SessionContext::hint(const std::string& text) {
  constexpr double kSeconds = 15;
  if (std::ranges::find(hints, text) != hints.end()) return;
  hints.push_back(text);
  notify(text, kSeconds);
}

bool SessionContext::removeOldNotices() {
  const double now = redraw.now();
  return std::erase_if(notices, [&](const ViewNotice& n) { return n.until < now; }) > 0;
}

ClassFilter::ClassFilter(const std::vector<std::string>& names, bool only, const Ontology* ontology)
    : only_(only && !names.empty()) {
  for (const std::string& name : names) {
    std::uint16_t id = 0;
    const auto read = std::from_chars(name.data(), name.data() + name.size(), id);
    if (read.ec == std::errc() && read.ptr == name.data() + name.size()) {
      listed_.insert(id);
    } else if (ontology != nullptr) {
      listed_.insert(ontology->require(name, {}).id);
    } else {
      throw InputError(fmt::format(
          "the classes have no names here: give the id of '{}' in its place, or the names by --ontology FILE", name));
    }
  }
}

void ClassFilter::toggle(std::uint16_t id) {
  if (listed_.erase(id) == 0) listed_.insert(id);
}

void ClassFilter::showOnly(std::uint16_t id) {
  only_ = true;
  listed_ = {id};
}

void ClassFilter::showAll() {
  only_ = false;
  listed_.clear();
}

std::string ClassFilter::text(const Ontology* ontology) const {
  if (showsAll()) return {};
  if (listed_.empty()) return "all classes hidden";
  constexpr std::size_t kNamed = 3;
  std::string out = only_ ? "only " : "without ";
  std::size_t named = 0;
  for (const std::uint16_t id : listed_) {
    if (named == kNamed) return out + fmt::format(" and {} more", listed_.size() - kNamed);
    out += (named++ == 0 ? "" : ", ") + className(ontology, id);
  }
  return out;
}

namespace {

InstanceSummary summaryOf(const Scan& scan, std::span<const Vec3f> placed, std::uint32_t instance,
                          std::vector<std::uint32_t> points, const Affine& levelFromPlaces) {
  InstanceSummary summary;
  summary.id = instance;
  std::map<std::uint16_t, std::uint64_t> classes;
  std::vector<Vec2d> ground;
  ground.reserve(points.size());
  for (const std::uint32_t i : points) {
    const Vec3d p = levelFromPlaces * Vec3d(placed[i]);
    ground.push_back({p.x, p.y});
    if (!scan[kLabel].empty()) ++classes[scan[kLabel][i]];
  }
  summary.classes.assign(classes.begin(), classes.end());
  std::ranges::stable_sort(summary.classes, std::greater<>(), [](const auto& entry) { return entry.second; });
  summary.levelFromBox.linear = toMatrix(fromYawPitchRoll(longSideOf(std::move(ground)), 0, 0));
  const Mat3 boxFromLevel = transposed(summary.levelFromBox.linear);
  Box box;
  for (const std::uint32_t i : points) box.add(boxFromLevel * (levelFromPlaces * Vec3d(placed[i])));
  if (!box.empty()) {
    summary.size = box.high - box.low;
    summary.levelFromBox.translation = summary.levelFromBox.linear * box.center();
  }
  summary.points = std::move(points);
  return summary;
}

}  // namespace

InstanceSummary summarizeInstance(const Scan& scan, std::span<const Vec3f> places, std::uint32_t instance,
                                  const Affine& levelFromPlaces) {
  std::vector<std::uint32_t> points;
  for (std::size_t i = 0; i < scan[kInstance].size(); ++i) {
    if (scan[kInstance][i] == instance && isFinite(places[i])) points.push_back(static_cast<std::uint32_t>(i));
  }
  return summaryOf(scan, places, instance, std::move(points), levelFromPlaces);
}

std::vector<InstanceSummary> summarizeInstances(const Scan& scan, std::span<const Vec3f> places,
                                                const Affine& levelFromPlaces) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> points;
  for (std::size_t i = 0; i < scan[kInstance].size(); ++i) {
    if (scan[kInstance][i] != 0 && isFinite(places[i])) {
      points[scan[kInstance][i]].push_back(static_cast<std::uint32_t>(i));
    }
  }
  std::vector<InstanceSummary> all;
  all.reserve(points.size());
  for (auto& [id, own] : points) all.push_back(summaryOf(scan, places, id, std::move(own), levelFromPlaces));
  return all;
}

}  // namespace scanmill
