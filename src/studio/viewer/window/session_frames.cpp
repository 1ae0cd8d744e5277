// Requests frames and scenes, shows those that have been loaded, and plays frames.

#include <fmt/core.h>

#include <algorithm>

#include "viewer/window/session_state.h"

namespace scanmill {

void ViewSession::State::goTo(std::size_t target, int step) {
  seeking = false;
  wantFrame(target, step);
}

void ViewSession::State::wantFrame(std::size_t target, int step) {
  wanted = std::min(target, source->keys().size() - 1);
  loader->want(wanted, step);
  hudChanged = true;
  takeWhatIsLoaded();
}

void ViewSession::State::stepBy(std::ptrdiff_t count) {
  const auto last = static_cast<std::ptrdiff_t>(source->keys().size()) - 1;
  const std::ptrdiff_t target = std::clamp(static_cast<std::ptrdiff_t>(wanted) + count, std::ptrdiff_t{0}, last);
  if (target == static_cast<std::ptrdiff_t>(wanted)) {
    say(count > 0 ? "this is the last frame" : "this is the first frame");
    return;
  }
  goTo(static_cast<std::size_t>(target), count > 0 ? 1 : -1);
}

void ViewSession::State::togglePlaying() {
  if (!playing && source->keys().size() < 2) return say("there is one frame only");
  playing = !playing;
  hudChanged = true;
  if (!playing) return;
  lastStep = clock.seconds();
  if (wanted + 1 >= source->keys().size()) goTo(0, 1);
}

double ViewSession::State::frameSeconds() const {
  constexpr double kLeast = 0.1;  // s: at most ten frames per second
  constexpr double kMost = 0.2;   // s: recordings with longer intervals are played faster than they were recorded
  const double times = kPlaySpeeds[speed];
  return times > 0 ? std::clamp(recordedSeconds, kLeast, kMost) / times : 0;
}

std::string ViewSession::State::speedText() const {
  const double times = kPlaySpeeds[speed];
  return times > 0 ? fmt::format("{}x", times) : "as fast as it loads";
}

void ViewSession::State::changeSpeed(int step) {
  if (source->keys().size() < 2) return say("there is one frame only");
  const int last = static_cast<int>(kPlaySpeeds.size()) - 1;
  speed = static_cast<std::size_t>(std::clamp(static_cast<int>(speed) + step, 0, last));
  say("playing speed: " + speedText());
}

// If the user did not choose the frame and it cannot be loaded, requests other frames until one can be loaded.
void ViewSession::State::seekReadable() {
  const auto known = source->damaged();
  const std::size_t count = source->keys().size();
  while (seekAt < count && (unreadable.contains(seekAt) || std::binary_search(known.begin(), known.end(), seekAt))) {
    ++seekAt;
  }
  if (seekAt < count) return wantFrame(seekAt++, 1);
  goTo(firstWanted, 1);
}

void ViewSession::State::hintAtNames() {
  if (source->ontology() != nullptr) return;
  const bool labelled = std::any_of(frame->scans.begin(), frame->scans.end(),
                                    [](const ViewScan& scan) { return !scan.scan[kLabel].empty(); });
  if (!labelled) return;
  hint(
      "the classes have no names here: a scan or shard away from its dataset does not know them; "
      "open it with --ontology labels/scanmill.yaml, or the file of its own classes");
}

void ViewSession::State::takeWhatIsLoaded() {
  if (!at || *at != wanted) {
    if (auto loaded = loader->frame(wanted)) adopt(std::move(loaded));
  }
  if (meshOn() && meshWanted) {
    auto loaded = loader->mesh(*meshWanted);
    if (loaded && loaded != mesh) takeMesh(std::move(loaded));
  }
}

void ViewSession::State::adopt(std::shared_ptr<const ViewFrame> loaded) {
  const auto timeOf = [](const ViewFrame& f) { return f.scans.empty() ? 0.0 : f.scans.front().time; };
  const bool next = at && frame && wanted == *at + 1;
  recordedSeconds = next ? timeOf(*loaded) - timeOf(*frame) : 0;
  frame = std::move(loaded);
  at = wanted;
  if (frame->scans.empty() && !source->isScene()) {
    unreadable.insert(*at);
    if (seeking) return seekReadable();
  } else {
    unreadable.erase(*at);
    if (seeking && *at != firstWanted) {
      hint(fmt::format("{} cannot be read: {} is the first that can", source->keys()[firstWanted], frame->key));
    }
  }
  seeking = false;
  damaged = source->damaged();
  damaged.insert(damaged.end(), unreadable.begin(), unreadable.end());
  std::sort(damaged.begin(), damaged.end());
  hintAtNames();
  hover.reset();
  pinned.reset();
  lastSummary.reset();
  instancesOf.reset();
  ends.clear();
  measuring = false;
  worldFromAnchor.reset();
  for (const ViewScan& scan : frame->scans) {
    if (scan.worldFromSensor && !worldFromAnchor) worldFromAnchor = scan.worldFromSensor;
  }
  trajectory = source->trajectory(*at);
  lastStep = clock.seconds();
  place();
  arrange();
  if (meshOn()) wantMesh();
  if (meshItem.there() != meshSeen()) placeMesh();
}

void ViewSession::State::wantMesh() {
  if (!at) return;
  std::string why;
  const auto choice = source->scene(*at, why);
  meshProblem.clear();
  if (!choice) {
    meshWanted.reset();
    if (mesh) takeMesh(nullptr);
    meshProblem = source->isScene() ? why : "no mesh: " + why;
    return;
  }
  meshWanted = choice;
  loader->wantMesh(*choice);
  takeWhatIsLoaded();
}

void ViewSession::State::takeMesh(std::shared_ptr<const ViewMesh> loaded) {
  mesh = std::move(loaded);
  meshProblem = mesh ? mesh->problem : "";
  hudChanged = true;
  placeMesh();
}

std::vector<std::string> ViewSession::State::problems() const {
  std::vector<std::string> all;
  if (frame) all = frame->problems;
  for (const std::string* one : {&colorProblem, &meshProblem, &stripProblem, &instanceProblem}) {
    if (!one->empty() && std::find(all.begin(), all.end(), *one) == all.end()) all.push_back(*one);
  }
  return all;
}

}  // namespace scanmill
