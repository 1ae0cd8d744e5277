// Draws the picture: views, labels and panels.

#include "viewer/window/session_state.h"

namespace scanmill {

void ViewSession::State::refresh() {
  panels.arrange();
  context.drawing.setViews(panels.views());
}

void ViewSession::State::updateHover() {
  const bool covered = panels.help || panels.toolkit.hasPointer();
  pointer.updateHover(covered, panels.overStrip && !panels.help ? std::optional(panels.stripRect()) : std::nullopt);
}

void ViewSession::State::flush(bool whole) {
  const double began = context.drawing.now();
  const Changes& changes = context.changes;
  if (changes.views || changes.items || changes.panels) refresh();
  if (changes.items && pointer.pinned && !pointer.isShown(*pointer.pinned)) pointer.pinned.reset();
  // When the picture changes, another point may be under the pointer, even if the pointer rests.
  if (changes.hover || changes.views || changes.items) {
    const bool held = panels.toolkit.hasPointer();
    runPanels();
    if (held || panels.toolkit.hasPointer())
      context.changes.panels = true;  // panels highlight their parts under the pointer
    updateHover();
  }
  pointer.lightInstance();
  pointer.placeBeam();
  if (changes.views || changes.items || changes.panels || changes.light) {
    panels.addLabels();
    runPanels();
    runPanels();  // sizes that depend on contents are known in the second run
  }
  std::uint64_t points = 0;
  for (const ShownCloud& cloud : clouds.list) points += cloud.visible;
  context.drawing.draw(whole, points, clouds.list.size(), began);
}

}  // namespace scanmill
