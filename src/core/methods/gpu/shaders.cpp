#include "methods/gpu/shaders.h"

#include <fmt/format.h>

#include <bit>

#include "gpu/compute.h"
#include "methods/field/distance_field.h"
#include "methods/field/march_rule.h"
#include "methods/field/particle_launch.h"
#include "methods/gpu/device_resolver.h"

namespace scanmill {

extern const std::string_view kLaunchShader;
extern const std::string_view kMarchNearestShader;
extern const std::string_view kMarchListsShader;
extern const std::string_view kHitsNearestShader;
extern const std::string_view kHitsListsShader;

namespace {

// Returns the constants that several programs share: the outcomes of particles and the layout of bricks.
std::string fieldConstants() {
  return glslConstant("kDistanceStep", kDistanceStep) + glslConstant("kBrickStride", kBrickStride + 0u) +
         glslConstant("kNoWord", kNoWord) + glslConstant("kFullBrick", kFullBrick) +
         glslConstant("kHit", static_cast<std::uint32_t>(Outcome::Hit)) +
         glslConstant("kExhausted", static_cast<std::uint32_t>(Outcome::Exhausted)) + glslConstant("kGoOn", kGoOn);
}

static_assert(kChannels.size() == 8, "give the new channel a constant here, and fill it in shaders/resolver.glsl");

std::string resolverConstants() {
  const auto channel = [](const char* name, Channel c) { return glslConstant(name, static_cast<std::uint32_t>(c)); };
  const auto verdict = [](const char* name, RayVerdict v) { return glslConstant(name, static_cast<std::uint32_t>(v)); };
  return channel("kNormal", Channel::Normal) + channel("kInstance", Channel::Instance) +
         channel("kSemantic", Channel::Semantic) + channel("kMaterial", Channel::Material) +
         channel("kPrimitive", Channel::Primitive) + channel("kReflectance", Channel::Reflectance) +
         channel("kIncidence", Channel::Incidence) + verdict("kOpen", RayVerdict::Open) +
         verdict("kExhaustedRay", RayVerdict::Exhausted) + verdict("kLeftRay", RayVerdict::Left) +
         glslConstant("kInfinite", std::bit_cast<std::uint32_t>(kMiss)) + glslConstant("kLetsPass", kLetsPass) +
         glslConstant("kCutOut", kCutOut + 0u) + glslConstant("kTextured", kTextured + 0u);
}

// Returns the text of a program: constants, followed by the text of a file.
std::string program(std::string constants, std::string_view text) {
  return constants.append(text);
}

}  // namespace

std::string launchShader(bool lists) {
  return program(glslConstant("kTogether", ParticleLaunch::kTogether + 0u) +
                     fmt::format("const bool kLists = {};\n", lists) + glslConstant("kLeftOut", kLeftOut),
                 kLaunchShader);
}

std::string marchShader(bool lists) {
  return program(fieldConstants() + glslConstant("kLastOfList", kLastOfList) + glslConstant("kNamed", kNamed) +
                     glslConstant("kListed", kListed) + glslConstant("kRest", kRest) +
                     glslConstant("kMiss", static_cast<std::uint32_t>(Outcome::Miss)) +
                     glslConstant("kEmptyBend", kEmptyBend) + glslConstant("kNamedBend", kNamedBend) +
                     glslConstant("kListedBend", kListedBend) + glslConstant("kSeam", kSeam) +
                     glslConstant("kBehind", kBehind) + glslConstant("kTie", kTie) + glslConstant("kNudge", kNudge) +
                     glslConstant("kFace", kFace),
                 lists ? kMarchListsShader : kMarchNearestShader);
}

std::string particleHitsShader(bool lists) {
  return program(fieldConstants() + resolverConstants() + glslConstant("kTogether", ParticleLaunch::kTogether + 0u) +
                     glslConstant("kLeftOut", kLeftOut) + glslConstant("kDone", kParticleDone) +
                     glslConstant("kBehindHole", kBehindHole) + glslConstant("kBehindHoleShare", kBehindHoleShare),
                 lists ? kHitsListsShader : kHitsNearestShader);
}

}  // namespace scanmill
