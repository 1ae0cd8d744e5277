// Other authors' methods of finding a beam's pixel, in simplified form, to measure how much accuracy they cost.
//
// RowHyperbola     Wolf et al.: a ring is the hyperbola v = cy - fy tan(elevation) sqrt(1 + ((u - cx) / fx)^2) in an
//                  upright image, and a beam's column is that of the head's azimuth. Azimuth offsets of rings and
//                  origins of beams are ignored.
// Equirectangular  Hossny et al.: the images are warped into a panorama by nearest pixels, with the same angle per
//                  pixel as at the images' centres; a beam takes the panorama's pixel. This rounds twice, not once.
// PixelRow         Negative control: rings are spread evenly over the rows of the image, azimuths evenly over its
//                  columns, and the depth Z is taken as the range.

#include <algorithm>
#include <cmath>

#include "methods/depth_camera/views.h"

namespace scanmill {

namespace {

bool upright(const CameraView& view) {
  return std::abs(view.forward.z) < 1e-9 && std::abs(view.right.z) < 1e-9;
}

void placeRowHyperbola(std::span<const CameraView> views, const BeamTable& table, const std::uint32_t* beam,
                       std::size_t count, ImagePositions places) {
  alignas(64) double x[kBlock] = {}, y[kBlock] = {}, z[kBlock] = {}, slope[kBlock];
  for (std::size_t i = 0; i < count; ++i) {
    const double azimuth = table.azimuth(beam[i] % table.columns);
    slope[i] = std::tan(table.elevation[beam[i] / table.columns]);
    x[i] = std::cos(azimuth);
    y[i] = std::sin(azimuth);
    z[i] = slope[i];
  }
  place(views, x, y, z, count, false, places);
  for (std::size_t i = 0; i < count; ++i) {
    if (places.view[i] == kNoView) continue;
    const CameraView& view = views[places.view[i]];
    if (!upright(view)) continue;
    const double across = (std::floor(places.u[i]) + 0.5 - view.cx) / view.fx;
    const double v = view.cy - view.fy * slope[i] * std::sqrt(1 + across * across);
    places.v[i] = std::clamp(v, 0.0, view.lastV);
  }
}

void placeEquirectangular(std::span<const CameraView> views, const BeamBlock& beams, ImagePositions places) {
  alignas(64) double x[kBlock] = {}, y[kBlock] = {}, z[kBlock] = {};
  const double pitch = views.empty() ? 1 : 1 / views.front().fx;  // rad per pixel of the panorama
  const auto centre = [&](double angle) { return (std::floor(angle / pitch) + 0.5) * pitch; };
  for (std::size_t i = 0; i < beams.count; ++i) {
    const double azimuth = centre(std::atan2(beams.dy[i], beams.dx[i]));
    const double elevation = centre(std::asin(std::clamp(beams.dz[i], -1.0, 1.0)));
    x[i] = std::cos(elevation) * std::cos(azimuth);
    y[i] = std::cos(elevation) * std::sin(azimuth);
    z[i] = std::sin(elevation);
  }
  place(views, x, y, z, beams.count, false, places);
}

void placePixelRow(std::span<const CameraView> views, const BeamTable& table, const std::uint32_t* beam,
                   std::size_t count, ImagePositions places) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t ring = beam[i] / table.columns;
    const double rank = (table.topDown || table.elevation.front() >= table.elevation.back())
                            ? ring
                            : static_cast<double>(table.rings) - 1 - ring;
    const double azimuth = table.azimuth(beam[i] % table.columns);
    const Vec3d head{std::cos(azimuth), std::sin(azimuth), 0};
    double nearest = 0;
    places.view[i] = kNoView;
    for (std::size_t k = 0; k < views.size(); ++k) {
      const CameraView& view = views[k];
      const double depth = dot(view.forward, head);
      const double angle = std::atan2(dot(view.right, head), depth);
      const double left = std::atan(-view.cx / view.fx);
      const double right = std::atan((view.width - view.cx) / view.fx);
      if (!upright(view) || depth <= nearest || angle < left - 1e-9 || angle > right + 1e-9) continue;
      nearest = depth;
      places.view[i] = static_cast<std::uint8_t>(k);
      places.u[i] = std::clamp((angle - left) / (right - left) * view.width, 0.0, view.lastU);
      places.v[i] = (rank + 0.5) / table.rings * view.height;
    }
  }
}

}  // namespace

void placeNaive(Sampling sampling, std::span<const CameraView> views, const BeamTable& table, const BeamBlock& beams,
                const std::uint32_t* beam, ImagePositions places) {
  if (sampling == Sampling::RowHyperbola) {
    placeRowHyperbola(views, table, beam, beams.count, places);
  } else if (sampling == Sampling::Equirectangular) {
    placeEquirectangular(views, beams, places);
  } else {
    placePixelRow(views, table, beam, beams.count, places);
  }
}

}  // namespace scanmill
