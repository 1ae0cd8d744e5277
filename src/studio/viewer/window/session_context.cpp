#include "viewer/window/session_context.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>

#include "base/error.h"
#include "viewer/color_map.h"

namespace scanmill {

void SessionContext::say(const std::string& text, double seconds) {
  // A notice that a key causes replaces older notices of the same key.
  std::erase_if(notices, [&](const ViewNotice& n) { return n.text == text || (acting && n.cause == acting); });
  notices.push_back({text, drawing.now() + seconds, acting});
  changes.panels = true;
}

void SessionContext::hint(const std::string& text) {
  constexpr double kSeconds = 15;
  if (std::ranges::find(hints, text) != hints.end()) return;
  hints.push_back(text);
  say(text, kSeconds);
}

bool SessionContext::forgetNotices() {
  const double now = drawing.now();
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

}  // namespace scanmill
