#include "viewer/window/session_context.h"

#include <fmt/core.h>

#include <charconv>

#include "base/error.h"
#include "base/short_text.h"
#include "scene/thing_boxes.h"

namespace scanmill {

void SessionContext::notify(const std::string& text, double seconds) {
  // A notice that a key causes replaces older notices of the same key.
  std::erase_if(notices,
                [&](const ViewNotice& n) { return n.text == text || (executing != nullptr && n.cause == executing); });
  notices.push_back({text, redraw.now() + seconds, executing});
  changes.panels = true;
}

void SessionContext::hint(const std::string& text) {
  constexpr double kSeconds = 15;
  if (std::ranges::find(hints, text) != hints.end()) return;
  hints.push_back(text);
  notify(text, kSeconds);
}

ClassFilter::ClassFilter(const std::vector<std::string>& names, bool only, const Ontology* ontology)
    : only_(only && !names.empty()) {
  for (const std::string& name : names) {
    std::uint16_t id = 0;
    const char* const end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data(), end, id);
    if (error == std::errc() && stop == end) {
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

std::string ClassFilter::text(const Ontology* ontology) const {
  if (showsAll()) return {};
  if (listed_.empty()) return "all classes hidden";
  constexpr std::size_t kMostNames = 3;
  std::vector<std::string> names;
  for (const std::uint16_t id : listed_) names.push_back(className(ontology, id));
  return (only_ ? "only " : "without ") + shortList(names, kMostNames);
}

namespace {

// Returns an instance's summary. `points`: indices of its points. Other parameters: see summarizeInstances().
InstanceSummary summaryOf(const Scan& scan, std::span<const Vec3f> positions, std::uint32_t instance,
                          std::vector<std::uint32_t> points, const Affine& levelFromPoints) {
  InstanceSummary summary;
  summary.id = instance;
  std::map<std::uint16_t, std::uint64_t> classes;
  std::vector<Vec2d> horizontal;  // positions without their heights
  for (const std::uint32_t i : points) {
    const Vec3d p = levelFromPoints * Vec3d(positions[i]);
    horizontal.push_back({p.x, p.y});
    if (!scan[kLabel].empty()) ++classes[scan[kLabel][i]];
  }
  summary.classes.assign(classes.begin(), classes.end());
  std::ranges::stable_sort(summary.classes, std::greater<>(), [](const auto& entry) { return entry.second; });
  summary.levelFromBox.linear = toMatrix(fromYawPitchRoll(longSideOf(std::move(horizontal)), 0, 0));
  const Mat3 boxFromLevel = transposed(summary.levelFromBox.linear);
  Box box;
  for (const std::uint32_t i : points) box.add(boxFromLevel * (levelFromPoints * Vec3d(positions[i])));
  if (!box.empty()) {
    summary.size = box.high - box.low;
    summary.levelFromBox.translation = summary.levelFromBox.linear * box.center();
  }
  summary.points = std::move(points);
  return summary;
}

}  // namespace

std::vector<InstanceSummary> summarizeInstances(const Scan& scan, std::span<const Vec3f> positions,
                                                const Affine& levelFromPoints, std::optional<std::uint32_t> only) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> pointsOf;  // the keys are instance ids
  for (std::size_t i = 0; i < scan[kInstance].size(); ++i) {
    const std::uint32_t id = scan[kInstance][i];
    if (id != 0 && (!only || id == *only) && isFinite(positions[i]))
      pointsOf[id].push_back(static_cast<std::uint32_t>(i));
  }
  std::vector<InstanceSummary> summaries;
  summaries.reserve(pointsOf.size());
  for (auto& [id, points] : pointsOf) {
    summaries.push_back(summaryOf(scan, positions, id, std::move(points), levelFromPoints));
  }
  return summaries;
}

}  // namespace scanmill
