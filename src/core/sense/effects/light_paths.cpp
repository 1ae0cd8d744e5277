// light_paths: rays continue behind glass and off mirrors.
//
//   light_paths: {panes: 4, bounces: 1}
//   light_paths: {bounces: 2, mirrored: unlabeled, least: 0.0001}
//
// Each hit of a continued ray is a separate echo: with cause 3 (ThroughGlass) behind glass, with cause 4 (Mirrored) for
// mirror images, which are placed where the sensor assumes them. The code is in methods/interface/light_paths.h.

#include "methods/interface/light_paths.h"

#include <algorithm>

#include "sense/effects/makers.h"

namespace scanmill {
namespace {

class LightPathsEffect : public Effect {
 public:
  explicit LightPathsEffect(const LightPaths& paths) : paths_(paths) {}

  const LightPaths* lightPaths() const override { return &paths_; }
  // Each pane may add one return per ray, each bounce two; the total is at most kMostReturns.
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
