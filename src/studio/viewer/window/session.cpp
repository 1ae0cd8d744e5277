#include "viewer/window/session.h"

#include <fmt/core.h>

#include "base/append_new.h"
#include "base/error.h"

namespace scanmill {

namespace {

// Throws InputError if no point of the frame's scans is in the close-up. The message states the nearest point.
void requirePoints(const ViewFrame& frame, const CloseUp& closeUp) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double leastDistance = kNone;
  Vec3d nearest;
  for (const ViewScan& viewed : frame.scans) {
    for (const Vec3f& p : viewed.scan.position) {
      const double distance = length(Vec3d(p) - closeUp.center);
      if (!(distance < leastDistance)) continue;
      leastDistance = distance;
      nearest = Vec3d(p);
    }
  }
  if (leastDistance <= closeUp.radius) return;
  const auto text = [](const Vec3d& v) { return fmt::format("{:.4g},{:.4g},{:.4g}", v.x, v.y, v.z); };
  throw InputError(fmt::format(
      "no point is within {:.4g} m of {}: {}", closeUp.radius, text(closeUp.center),
      leastDistance == kNone ? std::string("there is none at all")
                             : fmt::format("the nearest is {:.4g} m from there, at {}; take another --at or a larger "
                                           "--within",
                                           leastDistance, text(nearest))));
}

}  // namespace

ViewSession::ViewSession(std::shared_ptr<const FrameSource> source, Canvas& canvas, const ViewOptions& options,
                         std::unique_ptr<FrameLoader> loader)
    : context_(std::move(source), canvas, options),
      playback_(context_.source, loader ? std::move(loader) : std::make_unique<FrameLoader>(context_.source),
                options.sample),
      clouds_(context_),
      sceneView_(context_, clouds_),
      pointer_(context_, clouds_, sceneView_),
      panels_(context_, playback_, clouds_, sceneView_, pointer_) {
  if (context_.source->isScene() && !options.colors.empty()) {
    const ColorBy& by = options.colors.front();
    if (const std::string why = whyNoMeshColor(by); !why.empty()) {
      throw InputError(fmt::format("{}: {}", context_.source->title(), why));
    }
    chooseColor(by);
  }
  takeWhatIsLoaded();
}

void ViewSession::drawWhenLoaded() {
  if (!playback_.isUpToDate()) playback_.loader().wait(playback_.requested());
  takeWhatIsLoaded();  // the frame, which determines the wanted mesh
  if (sceneView_.isMeshOn() && sceneView_.meshWanted) playback_.loader().waitMesh(*sceneView_.meshWanted);
  takeWhatIsLoaded();
  playback_.clearBusy();
  context_.notices.clear();
  context_.changes.panels = true;
  flush(Detail::AllPoints);
}

void ViewSession::check() const {
  if (clouds_.columnMissing) throw InputError(*clouds_.columnMissing);
  const auto& frame = context_.frame;
  const auto& mesh = sceneView_.mesh;
  const bool isEmpty =
      context_.source->isScene() ? mesh == nullptr || mesh->size() == 0 : !frame || frame->scans.empty();
  if (!isEmpty) {
    if (context_.filter.closeUp) requirePoints(*frame, *context_.filter.closeUp);
    return;
  }
  const std::vector<std::string> reasons = problems();
  const bool hasOtherSamples = context_.options.sample.empty() && context_.source->keys().size() > 1;
  throw Error((reasons.empty() ? "nothing could be loaded" : reasons.front()) +
              (hasOtherSamples ? "; name another sample by --sample (`verify` lists the damaged ones)" : ""));
}

std::optional<PickedElement> ViewSession::pick(int x, int y) {
  refresh();
  auto picked = pointer_.pick(x, y);
  if (picked) picked = pointer_.withOtherScans(std::move(*picked));
  return picked;
}

void ViewSession::pin(const PickedElement& picked) {
  pointer_.pinned = picked;
  context_.changes.panels = true;
}

void ViewSession::goTo(std::size_t target, int step) {
  playback_.goTo(target, step);
  context_.changes.panels = true;
  takeWhatIsLoaded();
}

void ViewSession::stepBy(std::ptrdiff_t count) {
  if (!playback_.stepBy(count))
    return context_.notify(count > 0 ? "this is the last frame" : "this is the first frame");
  context_.changes.panels = true;
  takeWhatIsLoaded();
}

void ViewSession::togglePlaying() {
  if (!playback_.playing() && playback_.count() < 2) return context_.notify("there is one frame only");
  playback_.togglePlaying(context_.redraw.now());
  context_.changes.panels = true;
  takeWhatIsLoaded();
}

// Tells the user if classes have no names.
void ViewSession::hintAtNames() {
  const bool hasLabels =
      std::ranges::any_of(context_.frame->scans, [](const ViewScan& scan) { return !scan.scan[kLabel].empty(); });
  if (context_.source->ontology() != nullptr || !hasLabels) return;
  context_.hint(
      "the classes have no names here: a scan or shard away from its dataset does not know them; "
      "open it with --ontology labels/scanmill.yaml, or the file of its own classes");
}

void ViewSession::takeWhatIsLoaded() {
  if (auto loaded = playback_.take(context_.redraw.now())) showFrame(std::move(loaded));
  if (sceneView_.isMeshOn() && sceneView_.meshWanted) {
    auto loaded = playback_.loader().mesh(*sceneView_.meshWanted);
    if (loaded && loaded != sceneView_.mesh) sceneView_.takeMesh(std::move(loaded));
  }
}

void ViewSession::showFrame(std::shared_ptr<const ViewFrame> loaded) {
  context_.frame = std::move(loaded);
  hintAtNames();
  pointer_.leaveFrame();
  sceneView_.takeFrame(*playback_.current());
  arrange();
  sceneView_.lookAtFirstPoints();
  if (sceneView_.isMeshOn()) wantMesh();
  if (sceneView_.meshPlaced != sceneView_.isMeshVisible()) sceneView_.placeMesh();
}

// Updates everything that depends on the frame and the layout.
void ViewSession::arrange() {
  clouds_.arrange();
  sceneView_.placeClouds();
  applyFilter();
  sceneView_.placeGuides();
  pointer_.placeMeasure();
  sceneView_.placeMeshLook();
}

void ViewSession::applyFilter() {
  clouds_.applyFilter();
  sceneView_.applyFilter();
  sceneView_.placeBoxes();
}

// Requests the scene of the current frame. If the scene is not known, removes the mesh and reports why.
void ViewSession::wantMesh() {
  if (!playback_.current()) return;
  std::string why;
  const auto choice = context_.source->scene(*playback_.current(), why);
  sceneView_.meshProblem.clear();
  if (!choice) {
    sceneView_.meshWanted.reset();
    if (sceneView_.mesh) sceneView_.takeMesh(nullptr);
    sceneView_.meshProblem = context_.source->isScene() ? why : "no mesh: " + why;
    return;
  }
  sceneView_.meshWanted = choice;
  playback_.loader().wantMesh(*choice);
  takeWhatIsLoaded();
}

std::vector<std::string> ViewSession::problems() const {
  std::vector<std::string> lines;
  if (context_.frame) lines = context_.frame->problems;
  for (const std::string* line :
       {&clouds_.colorProblem, &sceneView_.meshProblem, &clouds_.stripProblem, &clouds_.instanceProblem}) {
    if (!line->empty()) appendNew({*line}, lines);
  }
  return lines;
}

void ViewSession::refresh() {
  panels_.arrange();
  context_.redraw.setViews(panels_.views());
}

void ViewSession::updateHover() {
  const bool covered = panels_.help || panels_.imgui.hasPointer();
  pointer_.updateHover(covered, panels_.overStrip && !panels_.help ? std::optional(panels_.stripRect()) : std::nullopt);
}

// Draws a picture if something has changed. The order matters: first the rectangles of the views, then the point under
// the pointer, then labels and panels, which show this point.
void ViewSession::flush(Detail detail) {
  const double began = context_.redraw.now();
  const Changes& changes = context_.changes;
  if (changes.views || changes.items || changes.panels) refresh();
  if (changes.items) pointer_.hover.reset();
  if (changes.items && pointer_.pinned && !pointer_.isShown(*pointer_.pinned)) pointer_.pinned.reset();
  // When the picture changes, another point may be under the pointer, even if the pointer rests.
  if (changes.hover || changes.views || changes.items) {
    const bool wasOverPanel = panels_.imgui.hasPointer();
    runPanels();
    if (wasOverPanel || panels_.imgui.hasPointer())
      context_.changes.panels = true;  // panels highlight their parts under the pointer
    updateHover();
  }
  pointer_.highlightInstance();
  pointer_.placeBeam();
  if (changes.views || changes.items || changes.panels || changes.highlight) {
    panels_.addLabels();
    runPanels();
    runPanels();  // sizes that depend on contents are known in the second run
  }
  std::uint64_t points = 0;
  for (const ShownCloud& cloud : clouds_.list) points += cloud.visible;
  context_.redraw.draw(detail, points, clouds_.list.size(), began);
}

}  // namespace scanmill
