// Requests frames and scenes, shows those that have been loaded, and draws the picture: views, labels and panels.

#include <algorithm>

#include "viewer/window/session_state.h"

namespace scanmill {

void ViewSession::State::goTo(std::size_t target, int step) {
  playback.goTo(target, step);
  context.changes.panels = true;
  takeWhatIsLoaded();
}

void ViewSession::State::stepBy(std::ptrdiff_t count) {
  if (!playback.stepBy(count)) return context.say(count > 0 ? "this is the last frame" : "this is the first frame");
  context.changes.panels = true;
  takeWhatIsLoaded();
}

void ViewSession::State::togglePlaying() {
  if (!playback.playing() && playback.count() < 2) return context.say("there is one frame only");
  playback.togglePlaying(context.drawing.now());
  context.changes.panels = true;
  takeWhatIsLoaded();
}

void ViewSession::State::changeSpeed(int step) {
  if (playback.count() < 2) return context.say("there is one frame only");
  playback.changeSpeed(step);
  context.say("playing speed: " + playback.speedText());
}

void ViewSession::State::hintAtNames() {
  if (context.source->ontology() != nullptr) return;
  const bool labelled =
      std::ranges::any_of(context.frame->scans, [](const ViewScan& scan) { return !scan.scan[kLabel].empty(); });
  if (!labelled) return;
  context.hint(
      "the classes have no names here: a scan or shard away from its dataset does not know them; "
      "open it with --ontology labels/scanmill.yaml, or the file of its own classes");
}

void ViewSession::State::takeWhatIsLoaded() {
  if (auto loaded = playback.take(context.drawing.now())) showFrame(std::move(loaded));
  if (scenery.meshOn() && scenery.meshWanted) {
    auto loaded = playback.loader().mesh(*scenery.meshWanted);
    if (loaded && loaded != scenery.mesh) takeMesh(std::move(loaded));
  }
}

void ViewSession::State::showFrame(std::shared_ptr<const ViewFrame> loaded) {
  context.frame = std::move(loaded);
  if (!playback.substituted().empty()) context.hint(playback.substituted());
  hintAtNames();
  pointer.leaveFrame();
  scenery.takeFrame(*playback.current());
  arrange();
  scenery.lookAtFirstPoints();
  if (scenery.meshOn()) wantMesh();
  if (scenery.meshItem.there() != scenery.meshSeen()) placeMesh();
}

// Updates everything that depends on the frame and the layout.
void ViewSession::State::arrange() {
  clouds.arrange();
  scenery.placeClouds();
  applyFilter();
  scenery.placeGuides();
  pointer.placeMeasure();
  scenery.placeMeshLook();
}

void ViewSession::State::applyFilter() {
  clouds.applyFilter();
  scenery.applyFilter();
  scenery.placeBoxes();
  pointer.hover.reset();
}

void ViewSession::State::wantMesh() {
  if (!playback.current()) return;
  std::string why;
  const auto choice = context.source->scene(*playback.current(), why);
  scenery.meshProblem.clear();
  if (!choice) {
    scenery.meshWanted.reset();
    if (scenery.mesh) takeMesh(nullptr);
    scenery.meshProblem = context.source->isScene() ? why : "no mesh: " + why;
    return;
  }
  scenery.meshWanted = choice;
  playback.loader().wantMesh(*choice);
  takeWhatIsLoaded();
}

void ViewSession::State::takeMesh(std::shared_ptr<const ViewMesh> loaded) {
  scenery.takeMesh(std::move(loaded));
  pointer.hover.reset();
}

void ViewSession::State::placeMesh() {
  scenery.placeMesh();
  pointer.hover.reset();
}

std::vector<std::string> ViewSession::State::problems() const {
  std::vector<std::string> all;
  if (context.frame) all = context.frame->problems;
  for (const std::string* one :
       {&clouds.colorProblem, &scenery.meshProblem, &clouds.stripProblem, &clouds.instanceProblem}) {
    if (!one->empty() && std::ranges::find(all, *one) == all.end()) all.push_back(*one);
  }
  return all;
}

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
