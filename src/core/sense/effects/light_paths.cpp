// light_paths: rays go on behind glass and off mirrors.
//
//   light_paths: {panes: 4, bounces: 1}
//   light_paths: {bounces: 2, mirrored: unlabeled, least: 0.0001}
//
// Materials with a `transmission` let light through (two-way, by Fresnel's equations and what the glass absorbs), those
// of a roughness of at most 0.1 mirror. What a ray meets there is an echo of its own: returns behind glass have the
// cause 3 and the class of what they hit, mirror images the cause 4 and lie where the sensor believes them, as far
// along the beam as the light has gone. methods/interface/light_paths.h says how; nothing is left to do here.

#include "methods/interface/light_paths.h"

#include <algorithm>

#include "sense/effects/makers.h"

namespace scanmill {
namespace {

class LightPathsEffect : public Effect {
 public:
  explicit LightPathsEffect(const LightPaths& paths) : paths_(paths) {}

  Channels reads() const override { return Channel::Range; }  // those who follow the rays read more
  const LightPaths* lightPaths() const override { return &paths_; }
  // Each pane and each mirror adds one at most to each ray; no more than rows there are.
  std::uint32_t mostReturns(std::uint32_t before) const override {
    return std::min(before * (1 + paths_.panes + 2 * paths_.bounces), kMostReturns);
  }
  void apply(const Hits&, const Shot&, std::span<const Material>, Returns&) const override {}

 private:
  LightPaths paths_;
};

}  // namespace

std::unique_ptr<Effect> makeLightPaths(Fields& options) {
  LightPaths paths;
  paths.panes = static_cast<std::uint32_t>(options.integer("panes", 0, 16, 4));
  paths.bounces = static_cast<std::uint32_t>(options.integer("bounces", 0, 4, 1));
  paths.least = options.number("least", {1e-9, 1}, 0.001);
  paths.mirroredUnlabelled = options.choice("mirrored", {"class", "unlabeled"}, "class") == "unlabeled";
  options.finish();
  return std::make_unique<LightPathsEffect>(paths);
}

}  // namespace scanmill
