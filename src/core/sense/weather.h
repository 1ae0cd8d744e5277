#pragma once

// The optical properties of rain, snow, fog and dust: how much light they take from a beam, and how much they return.

namespace scanmill {

// The size distribution of drops: intercept * exp(-slope * D) drops per cubic metre and per millimetre of diameter D.
struct DropSizes {
  double intercept = 0;  // 1/(m^3 mm), density of drops at D = 0
  double slope = 1;      // 1/mm, decrease of the natural logarithm of the density with D

  // Returns the number of drops per cubic metre with a larger diameter than `diameter` (mm).
  double above(double diameter) const;
  // Returns the sum of the squared diameters of all drops in a cubic metre (mm^2/m^3).
  double squares() const { return 2 * intercept / (slope * slope * slope); }
};

// Returns the size distribution of raindrops at a rate (mm/h): Marshall and Palmer, "The distribution of raindrops with
// size", Journal of Meteorology 5, 1948, eqs. 1 to 3.
DropSizes rainDrops(double rate);
// Returns the size distribution of snowflakes at a rate (mm/h of water), by the diameter of the drops that they melt
// into: Gunn and Marshall, "The distribution with size of aggregate snowflakes", Journal of Meteorology 15, 1958.
DropSizes snowFlakes(double rate);

struct Weather {
  double extinction = 0;  // 1/m; exp(-extinction * r) of the light remains after r m (Beer and Lambert)
  // Sizes of sparse particles, such as raindrops: a beam hits at most one of them at a range. Intercept 0: none exist.
  DropSizes drops = {};
  // Echo of a drop (m^2 / mm^2): a drop of diameter D (mm) in a beam of area A (m^2) returns dropEcho * D^2 / A of the
  // power that a white Lambertian target filling the beam returns.
  double dropEcho = 0;
  // Backscatter (1/(m sr)) of dense small particles, which are not modelled one by one.
  double backscatter = 0;
};

// Return the optical properties of rain, snow, fog and dust, by a rate (mm/h of water) or a visibility (m,
// meteorological optical range); both must be above 0.
//
// The extinction cross section of a drop much wider than the wavelength is twice its area. Its backscatter, by ray
// optics, is the reflection of its front and its back face along the axis: a^2 / 4 (R + (1 - R)^2 R n^2 / (2 - n)^2)
// per steradian for the radius a, with R = ((n - 1) / (n + 1))^2 and n = 1.328, water at 905 nm. Snowflakes are spheres
// with a tenth of the density of water, which gives the visibility in snow that observers report (700 m at 1.5 mm/h),
// and the lidar ratio (extinction over backscatter) 25 sr; both are estimates.
//
// The extinction of fog and dust is -log(0.05) / visibility (Koschmieder's law with the contrast threshold of 5 % that
// defines the meteorological optical range). The lidar ratio of fog is 18.8 sr, as for drops of 5 to 50 um at 905 nm
// (O'Connor et al., "A technique for autocalibration of cloud lidar", Journal of Atmospheric and Oceanic Technology 21,
// 2004). The lidar ratio of dust is 50 sr (mineral dust has 40 to 60 sr).
Weather rainOf(double rate);
Weather snowOf(double rate);
Weather fogOf(double visibility);
Weather dustOf(double visibility);

// Returns the echo of fog or dust along `length` (m) of a beam, relative to a white Lambertian target at this range.
double mistEcho(const Weather& weather, double length);

// Returns the reflectance of a surface that is soaked with water, divided by the reflectance of the dry surface
// (`reflectance`, 0 to 1). The ratio is below 1, because water reflects part of the light that leaves the surface back
// to the surface (Angstrom, "The albedo of various surfaces of ground", Geografiska Annaler 7, 1925; see Lekner and
// Dorf, "Why some things are darker when wet", Applied Optics 27, 1988).
double dampness(double reflectance);
// Returns the fraction of light that passes through a film of standing water and out again (Fresnel), relative to
// normal incidence. `cosine`: cosine of the angle of incidence.
double filmTransmission(double cosine);

}  // namespace scanmill
