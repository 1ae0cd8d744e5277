// States which keys do nothing if a scene is shown without scans: it has triangles, but neither points nor frames.

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "viewer/window/session_state.h"

namespace scanmill {

std::string ViewSession::State::sceneLacks(const ColorBy& by) const {
  if (std::find(kMeshColorNames.begin(), kMeshColorNames.end(), by.name()) != kMeshColorNames.end()) return {};
  return fmt::format("a scene has no {}: it is coloured by {}", by.name(), fmt::join(kMeshColorNames, ", "));
}

std::string ViewSession::State::sceneLacks(const KeyMeaning& meaning) const {
  using enum KeyAction;
  static const std::vector<std::pair<std::vector<KeyAction>, const char*>> kLacks{
      {{LargerPoints, SmallerPoints}, "a scene has no points"},
      {{ToggleRangeRings}, "a scene has no sensor to draw range rings about"},
      {{ToggleTrajectory}, "a scene has no trajectory: a dataset of it has"},
      {{ToggleBoxes}, "a scene has no list of objects: a dataset of it may have"},
      {{ToggleMesh}, "the scene's mesh is all that there is"},
      {{NextFrame, PreviousFrame, TenFramesOn, TenFramesBack, FirstFrame, LastFrame, Play, GoTo},
       "a scene has no frames: a dataset of it has"},
      {{ToggleOverlay, ToggleSplit, NextView, NextScan}, "a scene has no scans: a dataset of it has"},
      {{ToggleWorld}, "a scene has no sensor to follow"},
      {{ToggleRangeImage}, "a scene has no range image: a dataset of it has"}};
  if (meaning.action == ColorByNumber) return sceneLacks(ColorBy(colorNames()[meaning.number]));
  for (const auto& [actions, lack] : kLacks) {
    if (std::find(actions.begin(), actions.end(), meaning.action) != actions.end()) return lack;
  }
  return {};
}

}  // namespace scanmill
