#include "methods/interface/light_paths.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace scanmill {

namespace {

constexpr double kStep = 1e-4;  // m; a continued ray starts this far from the surface, so as not to hit it again

// A ray that continues after a hit.
struct ContinuedRay {
  std::uint32_t beam;
  Vec3d origin;       // m, world axes, relative to the sensor's position at the start of the revolution
  Vec3d direction;    // unit vector, world axes
  double pathLength;  // m, length of the path so far
  double weight;
  std::uint32_t panes;
  std::uint32_t bounces;
  RayPath path;
};

class LightFollower {
 public:
  LightFollower(const Method& method, const Shot& shot, std::span<const Material> materials, const LightPaths& paths,
                Hits& hits)
      : method_(method), shot_(shot), materials_(materials), paths_(paths), hits_(hits) {
    for (const Material& m : materials) {
      continues_.push_back(m.transmission > 0 || (paths.bounces > 0 && m.roughness <= kMirrorRoughness) ? 1 : 0);
    }
  }

  TraceAccount follow() {
    markDirectRays();
    std::vector<ContinuedRay> continued = continuedFromSensor();
    TraceAccount account;
    while (!continued.empty()) {
      Hits found;
      account += method_.trace(shotOf(continued), hits_.channels, found);
      continued = add(continued, found);
    }
    return account;
  }

 private:
  // Fills beamOfRay, weightOfRay and pathOfRay of the hits for the rays traced so far.
  void markDirectRays() {
    if (hits_.beamOfRay.empty()) {
      hits_.beamOfRay.resize(hits_.rays());
      std::iota(hits_.beamOfRay.begin(), hits_.beamOfRay.end(), 0u);
      hits_.weightOfRay.assign(hits_.rays(), 1.0f);
    }
    hits_.pathOfRay.resize(hits_.rays(), RayPath::Direct);
    hits_.glassIsClear = true;
  }

  std::vector<ContinuedRay> continuedFromSensor() const {
    const BeamTable& rays = *shot_.beams;
    const Vec3d start = shot_.worldFromSensor.front().translation;
    std::vector<Mat3> rotation;
    for (const Pose& pose : shot_.worldFromSensor) rotation.push_back(toMatrix(pose.rotation));
    std::vector<ContinuedRay> continued;
    for (std::uint32_t ray = 0; ray < hits_.rays(); ++ray) {
      if (!continues(hits_.material[ray]) || !hits_.hit(ray)) continue;
      const std::size_t step = shot_.stepOf(ray % rays.columns);
      Vec3d origin = shot_.worldFromSensor[step].translation - start;
      if (!rays.origin.empty()) origin = origin + rotation[step] * Vec3d(rays.origin[ray]);
      const ContinuedRay before{
          hits_.beamOfRay[ray], origin, rotation[step] * rays.direction[ray], 0, hits_.weightOfRay[ray], 0, 0,
          RayPath::Direct};
      branch(before, hits_, ray, continued);
    }
    return continued;
  }

  bool continues(std::uint16_t material) const { return material < continues_.size() && continues_[material] != 0; }

  // Appends the rays that continue from a hit: one through a pane and one off a mirror, if the surface has these
  // properties.
  void branch(const ContinuedRay& before, const Hits& found, std::uint32_t ray,
              std::vector<ContinuedRay>& continued) const {
    const Material& material = materials_[found.material[ray]];
    const double cosine = found.incidence[ray];
    const Vec3d hitPoint = before.origin + before.direction * double{found.range[ray]};
    const auto continueRay = [&](double fraction, const Vec3d& direction, bool pane) {
      ContinuedRay next = before;
      next.weight *= fraction * fraction;
      if (next.weight < paths_.least) return;
      next.direction = direction;
      next.origin = hitPoint + direction * kStep;
      next.pathLength += double{found.range[ray]} + kStep;
      next.panes += pane ? 1 : 0;
      next.bounces += pane ? 0 : 1;
      next.path = !pane || before.path == RayPath::Mirrored ? RayPath::Mirrored : RayPath::ThroughGlass;
      continued.push_back(next);
    };
    if (material.transmission > 0 && before.panes < paths_.panes) {
      continueRay(paneOf(cosine, material.index, material.transmission).transmitted, before.direction, true);
    }
    if (before.bounces < paths_.bounces) {
      const Vec3d normal(found.normal[ray]);
      const Vec3d reflected = before.direction - normal * (2 * dot(before.direction, normal));
      continueRay(mirrored(material, cosine, found.reflectance[ray]), normalized(reflected), false);
    }
  }

  // Returns a shot with the rays `continued` as beams of a single ring, in world axes, relative to the sensor's
  // position.
  Shot shotOf(const std::vector<ContinuedRay>& continued) {
    auto table = std::make_shared<BeamTable>();
    table->model = shot_.beams->model;
    table->rings = 1;
    table->columns = static_cast<std::uint32_t>(continued.size());
    table->maxRange = shot_.beams->maxRange;
    table->period = shot_.beams->period;
    table->elevation = {0};
    remaining_.clear();
    for (const ContinuedRay& ray : continued) {
      table->direction.push_back(ray.direction);
      remaining_.push_back(static_cast<float>(std::max(0.0, shot_.beams->maxRange - ray.pathLength)));
      table->origin.push_back(Vec3f(ray.origin));
      table->time.push_back(timeOf(ray.beam));
    }
    Shot shot = shot_;
    shot.worldFromSensor = {Pose{{}, shot_.worldFromSensor.front().translation}};
    shot.beams = std::move(table);
    shot.blockedBeyond = remaining_;
    return shot;
  }

  // Returns the time at which a beam fires (s since the start of the revolution).
  float timeOf(std::uint32_t beam) const {
    const BeamTable& rays = *shot_.beams;
    return static_cast<float>(rays.columnTime(beam % (rays.columns / rays.raysPerBeam) * rays.raysPerBeam));
  }

  // Appends `found`, the hits of the rays `continued`, to hits_. Returns the rays that continue from these hits.
  std::vector<ContinuedRay> add(const std::vector<ContinuedRay>& continued, const Hits& found) {
    std::vector<ContinuedRay> further;
    for (std::uint32_t i = 0; i < continued.size(); ++i) {
      if (!found.hit(i)) continue;
      const ContinuedRay& ray = continued[i];
      const double pathLength = ray.pathLength + double{found.range[i]};
      if (pathLength > shot_.beams->maxRange) continue;
      if (continues(found.material[i])) branch(ray, found, i, further);
      if (pathLength < shot_.beams->minRange) continue;
      hits_.beamOfRay.push_back(ray.beam);
      hits_.weightOfRay.push_back(static_cast<float>(ray.weight));
      hits_.pathOfRay.push_back(ray.path);
      hits_.range.push_back(static_cast<float>(pathLength));
      forEachChannel([&](const ChannelRow& row, auto member) {
        auto& column = hits_.*member;
        if (row.channel != Channel::Range && !column.empty()) column.push_back((found.*member)[i]);
      });
      if (ray.path == RayPath::Mirrored && paths_.mirroredUnlabelled) {
        if (!hits_.semantic.empty()) hits_.semantic.back() = 0;
        if (!hits_.instance.empty()) hits_.instance.back() = 0;
      }
    }
    return further;
  }

  const Method& method_;
  const Shot& shot_;
  std::span<const Material> materials_;
  const LightPaths& paths_;
  Hits& hits_;
  std::vector<float> remaining_;         // m that each ray of the last shotOf() may continue within the sensor's range
  std::vector<std::uint8_t> continues_;  // by material: 1 if rays continue behind it or off it
};

}  // namespace

double fresnel(double cosine, double index) {
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine)) / index;
  if (sine >= 1) return 1;
  const double inside = std::sqrt(1 - sine * sine);
  const double across = (cosine - index * inside) / (cosine + index * inside);
  const double along = (index * cosine - inside) / (index * cosine + inside);
  return (across * across + along * along) / 2;
}

Pane paneOf(double cosine, double index, double inside) {
  const double face = fresnel(cosine, index);
  const double through = (1 - face) * (1 - face) * inside / (1 - face * face * inside * inside);
  return {face * (1 + inside * through), through};
}

double mirrored(const Material& material, double cosine, double reflectance) {
  if (material.roughness > kMirrorRoughness) return 0;
  if (material.transmission > 0) return paneOf(cosine, material.index, material.transmission).reflected;
  const double metal = reflectance + (1 - reflectance) * std::pow(1 - cosine, 5);
  return material.metallic * metal + (1 - material.metallic) * fresnel(cosine, material.index);
}

TraceAccount followLight(const Method& method, const Shot& shot, std::span<const Material> materials,
                         const LightPaths& paths, Hits& hits) {
  return LightFollower(method, shot, materials, paths, hits).follow();
}

}  // namespace scanmill
