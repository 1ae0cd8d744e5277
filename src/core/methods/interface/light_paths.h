#pragma once

// Follows rays through glass and off mirrors. Works with any method that can start rays anywhere: see
// MethodCapabilities::transmission.

#include <cstdint>
#include <span>

#include "methods/interface/method.h"
#include "scan/hits.h"
#include "scene/material.h"
#include "sensors/shot.h"

namespace scanmill {

struct LightPaths {
  std::uint32_t panes = 4;          // most panes that a ray passes
  std::uint32_t bounces = 1;        // most reflections of a ray off mirrors
  double least = 0.001;             // share of a beam's power below which a ray is not followed
  bool mirroredUnlabelled = false;  // hits seen in mirrors have class and instance 0, not those of the surface
};

// The channels that followLight() reads.
inline constexpr Channels kLightChannels =
    Channel::Range | Channel::Normal | Channel::Material | Channels(Channel::Reflectance) | Channel::Incidence;

// Materials of at most this roughness reflect as mirrors, in addition to scattering.
constexpr float kMirrorRoughness = 0.1f;

// Returns the share of unpolarised light that one face between air and a material of this refractive index reflects
// (Fresnel; Born and Wolf, "Principles of Optics", 7th edition, section 1.5.2). `cosine` is that of the angle of
// incidence.
double fresnel(double cosine, double index);

// The shares of light that a pane reflects and transmits in all. It has two faces between air and its material, and its
// inside transmits the share `inside`. Both are sums of the geometric series of internal reflections (Born and Wolf,
// section 7.6, without interference).
struct Pane {
  double reflected = 0;
  double transmitted = 0;
};
Pane paneOf(double cosine, double index, double inside);

// Returns the share of light that a surface reflects as a mirror: a pane, a metal (Schlick, "An inexpensive BRDF model
// for physically-based rendering", Eurographics 1994, eq. 15) or a smooth face. 0 if the material is rough.
double mirrored(const Material& material, double cosine, double reflectance);

// Continues rays through transmissive materials, in the same direction, and off mirrors, in the mirrored direction, as
// often as `paths` allows, and adds each continued ray to `hits`. Before, `hits` must hold kLightChannels for each ray
// of the shot's beam table (which may be a footprint's). An added ray has the beam that it comes from, its pathOfRay,
// the length of its complete path as its range, and a weight: that of the ray before times the square of the share of
// light that continues, since the echo returns along the same path. Continued rays that hit nothing within the sensor's
// range limits are not added.
TraceAccount followLight(const Method& method, const Shot& shot, std::span<const Material> materials,
                         const LightPaths& paths, Hits& hits);

}  // namespace scanmill
