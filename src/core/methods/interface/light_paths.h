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
  std::uint32_t panes = 4;          // largest number of panes that a ray passes
  std::uint32_t bounces = 1;        // largest number of reflections of a ray off mirrors
  double least = 0.001;             // fraction of a beam's power below which a ray is not followed
  bool mirroredUnlabelled = false;  // if true, hits seen in mirrors get class and instance 0
};

// The channels that followLight() reads.
inline constexpr Channels kLightChannels =
    Channel::Range | Channel::Normal | Channel::Material | Channels(Channel::Reflectance) | Channel::Incidence;

// Largest roughness of a material that reflects like a mirror, in addition to scattering.
constexpr float kMirrorRoughness = 0.1f;

// Returns the fraction of unpolarised light that one face between air and a material with this refractive index
// reflects, at this cosine of the angle of incidence (Fresnel; Born and Wolf, "Principles of Optics", 7th ed., 1.5.2).
double fresnel(double cosine, double index);

// paneOf() returns the fractions of light that a pane reflects and transmits in total. A pane has two faces between air
// and its material, and its inside transmits the fraction `inside`. Both totals are sums of the geometric series of
// internal reflections (Born and Wolf, section 7.6, without interference). `cosine`, `index`: see fresnel().
struct Pane {
  double reflected = 0;
  double transmitted = 0;
};
Pane paneOf(double cosine, double index, double inside);

// Returns the fraction of light that a surface reflects as a mirror, at this cosine of the angle of incidence. The
// fraction is 0 if the roughness exceeds kMirrorRoughness. A transmissive material reflects as a pane. Otherwise
// Material::metallic interpolates between a metal (Schlick, "An inexpensive BRDF model for physically-based rendering",
// 1994, eq. 15) and a smooth dielectric.
double mirrored(const Material& material, double cosine, double reflectance);

// Follows rays through transmissive materials (in the same direction) and off mirrors (in the mirrored direction), as
// often as `paths` allows, and appends the hit of each continued ray to `hits`. Before the call, `hits` must have
// kLightChannels for each ray of the shot's beam table, which may be the table of a footprint. An appended ray has the
// beam of the ray that it continues, a kind of path (pathOfRay), the length of the complete path as its range, and a
// weight: the weight of the ray that it continues, times the square of the fraction of light that continues, because
// the echo returns along the same path. Continued rays without a hit within the range limits are not appended.
TraceAccount followLight(const Method& method, const Shot& shot, std::span<const Material> materials,
                         const LightPaths& paths, Hits& hits);

}  // namespace scanmill
