#include "viewer/window/session_context.h"

#include <algorithm>

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

}  // namespace scanmill
