#pragma once

// Rays that go on behind glass and off mirrors. Any method that can start rays anywhere traces them: see
// MethodCapabilities::transmission.

#include <cstdint>
#include <span>

#include "methods/interface/method.h"
#include "scan/hits.h"
#include "scene/material.h"
#include "sensors/shot.h"

namespace scanmill {

struct LightPaths {
  std::uint32_t panes = 4;          // that a ray goes through at most
  std::uint32_t bounces = 1;        // off mirrors, at most
  double least = 0.001;             // share of a beam's power below which a ray is not followed
  bool mirroredUnlabelled = false;  // mirror images have class and instance 0, in place of those of what is mirrored
};

// The channels that followLight() reads.
inline constexpr Channels kLightChannels =
    Channel::Range | Channel::Normal | Channel::Material | Channels(Channel::Reflectance) | Channel::Incidence;

// Materials as smooth as this or smoother are mirrors besides whatever they scatter.
constexpr float kMirrorRoughness = 0.1f;

// The part of unpolarised light that one face between air and a material of this refractive index reflects (Fresnel;
// Born and Wolf, "Principles of Optics", 7th edition, section 1.5.2). `cosine`: of the angle of
// incidence.
double fresnel(double cosine, double index);

// A pane with two such faces, that lets the part `inside` of the light through its inside: all that it reflects, and
// all that it lets through, sums of the geometric series of reflections within (Born and Wolf, section 7.6, without
// interference).
struct Pane {
  double reflected = 0;
  double transmitted = 0;
};
Pane paneOf(double cosine, double index, double inside);

// What a surface sends on as a mirror: of a pane, a metal (Schlick, "An inexpensive BRDF model for physically-based
// rendering", Eurographics 1994, eq. 15) or a smooth face. 0 where it is rough.
double mirrored(const Material& material, double cosine, double reflectance);

// `hits` are those of the shot's beam table (which may be a footprint's), one a ray. Adds a ray for each that goes on:
// behind a material with a transmission in the same direction, off a mirror in the mirrored one; from there again, as
// far as `paths` allows. An added ray has its beam, the whole way as its range, pathOfRay, and as its weight that of
// the ray before times the square of what goes on, since what it meets comes back the same way. Rays that meet nothing
// within the sensor's limits are not added. Needs kLightChannels.
TraceAccount followLight(const Method& method, const Shot& shot, std::span<const Material> materials,
                         const LightPaths& paths, Hits& hits);

}  // namespace scanmill
