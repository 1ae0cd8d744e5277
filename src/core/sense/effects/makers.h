#pragma once

// The makers of the effects, for the rows of effects(). Each maker is defined in the file of its effect.

#include <memory>

#include "sense/effect.h"

namespace scanmill {

std::unique_ptr<Effect> makeIntensity(Fields& options);
std::unique_ptr<Effect> makeDropOut(Fields& options);
std::unique_ptr<Effect> makeRangeNoise(Fields& options);
std::unique_ptr<Effect> makeShellNoise(Fields& options);
std::unique_ptr<Effect> makeQuantize(Fields& options);
std::unique_ptr<Effect> makeAngularJitter(Fields& options);
std::unique_ptr<Effect> makeSpeckle(Fields& options);
std::unique_ptr<Effect> makeRingBias(Fields& options);
std::unique_ptr<Effect> makeFootprintEffect(Fields& options);
std::unique_ptr<Effect> makeDetection(Fields& options);
std::unique_ptr<Effect> makeLightPaths(Fields& options);
std::unique_ptr<Effect> makeReflectanceVariation(Fields& options);
std::unique_ptr<Effect> makeRelief(Fields& options);
std::unique_ptr<Effect> makeWeather(Fields& options);
std::unique_ptr<Effect> makeBlooming(Fields& options);
std::unique_ptr<Effect> makeRangeWalk(Fields& options);

}  // namespace scanmill
