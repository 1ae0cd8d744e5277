#pragma once

// What rain, snow, fog and dust do to light: how much they take from it, and how much they send back.

namespace scanmill {

// How many drops there are of each diameter D: intercept * exp(-slope * D) a cubic metre and millimetre.
struct DropSizes {
  double intercept = 0;  // 1/(m^3 mm)
  double slope = 1;      // 1/mm

  // Drops a cubic metre that are wider than a diameter (mm).
  double above(double diameter) const;
  // The integral of D^2 over all drops a cubic metre (mm^2/m^3).
  double squares() const;
};

// Raindrops at a rate in mm/h: Marshall and Palmer, "The distribution of raindrops with size", Journal of Meteorology
// 5, 1948, eqs. 1 to 3.
DropSizes rainDrops(double rate);
// Snowflakes by the diameter of the drops that they melt to, at a rate in mm/h of water: Gunn and Marshall, "The
// distribution with size of aggregate snowflakes", Journal of Meteorology 15, 1958.
DropSizes snowFlakes(double rate);

struct Weather {
  double extinction = 0;  // 1/m, light on its way loses exp(-extinction * r) (Beer and Lambert)
  // Particles that are so few that a beam meets one or none of them at a time; an intercept of 0: there are none.
  DropSizes drops;
  // A drop of the diameter D mm that a beam of the area A m^2 lights sends back dropEcho * D^2 / A of what a white matt
  // target does that fills the beam (mm^-2 m^2).
  double dropEcho = 0;
  // Of particles that are too many and too small to be told apart (1/(m sr)).
  double backscatter = 0;
};

// All rates in mm/h of water, all visibilities (meteorological optical range) in m; both above 0. Drops that are wide
// beside the wavelength take twice what they cover. They send back by the laws of ray optics what the front and the
// back face reflect along the axis: a^2 / 4 (R + (1 - R)^2 R n^2 / (2 - n)^2) a steradian for the radius a, with R =
// ((n - 1) / (n + 1))^2 and n = 1.328, water at 905 nm. Kilic et al., "Lidar light scattering
// augmentation (LISA)", arXiv 2107.07004, take the first term alone.
Weather rainOf(double rate);
// Flakes as spheres of a tenth of the density of water, which makes the visibility in snow that observers report (700 m
// at 1.5 mm/h); they send back 1 / 25 sr of what they take from the beam. Estimates: the density, and the lidar ratio,
// of which 20 to 35 sr are measured in clouds of ice.
Weather snowOf(double rate);
// Extinction -log(0.05) / visibility (Koschmieder's law with the contrast threshold of 5 % that defines the
// meteorological optical range); backscatter 0.046 / visibility (Hahner et al., "Fog simulation on real LiDAR point
// clouds", ICCV 2021, after Rasshofer et al., "Influences of weather phenomena on automotive laser radar systems",
// Advances in Radio Science 9, 2011).
Weather fogOf(double visibility);
// The same extinction, and a backscatter of a fiftieth of it a steradian. Estimate: mineral dust has lidar ratios of 40
// to 60 sr.
Weather dustOf(double visibility);

// A mist that fills `length` m of a beam sends back so much of what a white matt target does there.
double mistEcho(const Weather& weather, double length);

// The reflectance of a surface that has drawn in water, over its dry one: light that leaves it is reflected back inside
// the film and meets it again (Angstrom, "The albedo of various surfaces of ground", Geografiska Annaler 7, 1925; see
// Lekner and Dorf, "Why some things are darker when wet", Applied Optics 27, 1988). `reflectance`: dry, 0 to 1.
double dampness(double reflectance);
// What a film of standing water leaves of that at an angle of incidence, over what it leaves at normal incidence: the
// share that Fresnel's equations let in, there and back. `cosine`: of the angle.
double filmTransmission(double cosine);

}  // namespace scanmill
