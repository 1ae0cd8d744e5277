// angular_jitter: a beam does not point exactly in the direction that the sensor assumes. The point is reported with
// the right range, but in a wrong direction.
//
//   angular_jitter: {sigma_deg: 0.01}
//   angular_jitter: {azimuth_sigma_deg: 0.02, elevation_sigma_deg: 0.005}
//
// Azimuth errors rotate the beam about the sensor's z axis, as errors of the encoder do, and therefore change the
// direction of a steep beam less; elevation errors tilt the beam. Both are Gaussian and independent from beam to beam.
// The effect runs last, on the reported range.

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

// The largest error, 6.76 sigma, must stay below 45 degrees, the limit of sinCosSmall().
constexpr Range kSigmaDeg{0, 5};

class AngularJitter : public Effect {
 public:
  AngularJitter(double azimuthSigma, double elevationSigma)
      : azimuthSigma_(azimuthSigma), elevationSigma_(elevationSigma) {}

  void apply(const Hits&, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    change(shot, returns);
  }

 private:
  // Displaces each point as a random error of its beam's direction would.
  SCANMILL_BEST_INSTRUCTIONS void change(const Shot& shot, Returns& returns) const {
    if (azimuthSigma_ == 0 && elevationSigma_ == 0) return;
    returns.displacement.resize(returns.range.size());
    RandomWords words;
    Batch<Vec3d> directions;
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      const float* const range = returns.range.data() + first;
      const Vec3d* const direction = valuesOfBeams(returns, shot.beams->direction, first, directions);
      Vec3f* const displacement = returns.displacement.data() + first;
      drawWords(shot, Purpose::AngularJitter, returns, first, words);
      for (std::size_t i = 0; i < count; ++i) {
        const NormalPair normal = normalPair(words.a[i], words.b[i]);
        const SinCos azimuthError = sinCosSmall(azimuthSigma_ * normal.first);
        const SinCos elevationError = sinCosSmall(elevationSigma_ * normal.second);
        const double x = direction[i].x;
        const double y = direction[i].y;
        const double z = direction[i].z;
        // (forwardX, forwardY): the beam's horizontal direction, a unit vector. A vertical beam is tilted towards x.
        const double horizontal = std::sqrt(x * x + y * y);
        const double inverseHorizontal = 1 / (horizontal > 0 ? horizontal : 1.0);
        const double forwardX = horizontal > 0 ? x * inverseHorizontal : 1.0;
        const double forwardY = y * inverseHorizontal;
        const double tiltedHorizontal = horizontal * elevationError.cos - z * elevationError.sin;
        const double dx = (forwardX * azimuthError.cos - forwardY * azimuthError.sin) * tiltedHorizontal - x;
        const double dy = (forwardY * azimuthError.cos + forwardX * azimuthError.sin) * tiltedHorizontal - y;
        const double dz = z * elevationError.cos + horizontal * elevationError.sin - z;
        const double scale = range[i] < kMiss ? range[i] : 0.0;
        displacement[i].x += static_cast<float>(scale * dx);
        displacement[i].y += static_cast<float>(scale * dy);
        displacement[i].z += static_cast<float>(scale * dz);
      }
    });
  }

  double azimuthSigma_;    // rad, standard deviation of the errors in azimuth
  double elevationSigma_;  // rad, standard deviation of the errors in elevation
};

}  // namespace

std::unique_ptr<Effect> makeAngularJitter(Fields& options) {
  options.also({"sigma_deg", "azimuth_sigma_deg", "elevation_sigma_deg"}).finish();
  const bool oneSigma = options.has("sigma_deg");
  const bool sigmaPerAngle = options.has("azimuth_sigma_deg") || options.has("elevation_sigma_deg");
  if (oneSigma == sigmaPerAngle) {
    throw InputError(options.where(),
                     "effect angular_jitter: give either sigma_deg or azimuth_sigma_deg and elevation_sigma_deg");
  }
  const double sigma = options.number("sigma_deg", kSigmaDeg, 0);
  const double azimuth = options.number("azimuth_sigma_deg", kSigmaDeg, sigma);
  const double elevation = options.number("elevation_sigma_deg", kSigmaDeg, sigma);
  options.finish();
  return std::make_unique<AngularJitter>(radians(azimuth), radians(elevation));
}

}  // namespace scanmill
