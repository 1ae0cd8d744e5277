#include "methods/interface/light_paths.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace scanmill {

namespace {

constexpr double kStep = 1e-4;  // m; a continued ray starts this far from the surface, so as not to hit it again

// A ray that continues after a hit, or a ray of the shot itself, which starts at the sensor with a path length of 0.
struct ContinuedRay {
  std::uint32_t beam;
  Vec3d origin;               // m, world axes, relative to the sensor's position at the start of the revolution
  Vec3d direction;            // unit vector, world axes
  double pathLength = 0;      // m, length of the path from the sensor to `origin`
  double weight;              // see Hits::weightOfRay
  std::uint32_t panes = 0;    // number of panes that the path has passed
  std::uint32_t bounces = 0;  // number of reflections of the path
  RayPath path = RayPath::Direct;
};

enum class Continuation { ThroughPane, OffMirror };

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
    std::vector<ContinuedRay> rays = continueDirectRays();
    TraceAccount account;
    while (!rays.empty()) {
      Hits raysHits;
      account += method_.trace(shotOf(rays), hits_.channels, raysHits);
      rays = addHits(rays, raysHits);
    }
    return account;
  }

 private:
  // Fills beamOfRay, weightOfRay and pathOfRay of the hits for the shot's own rays.
  void markDirectRays() {
    if (hits_.beamOfRay.empty()) {
      hits_.beamOfRay.resize(hits_.rays());
      std::iota(hits_.beamOfRay.begin(), hits_.beamOfRay.end(), 0u);
      hits_.weightOfRay.assign(hits_.rays(), 1.0f);
    }
    hits_.pathOfRay.resize(hits_.rays(), RayPath::Direct);
    hits_.glassIsClear = true;
  }

  // Returns the rays that continue from the hits of the shot's own rays.
  std::vector<ContinuedRay> continueDirectRays() const {
    const BeamTable& beams = *shot_.beams;
    const Vec3d start = shot_.worldFromSensor.front().translation;
    std::vector<Mat3> rotation;
    for (const Pose& pose : shot_.worldFromSensor) rotation.push_back(toMatrix(pose.rotation));
    std::vector<ContinuedRay> continued;
    for (std::uint32_t i = 0; i < hits_.rays(); ++i) {
      if (!continues(hits_.material[i]) || !hits_.hit(i)) continue;
      const std::size_t step = shot_.stepOf(i % beams.columns);
      const Vec3d sensor = shot_.worldFromSensor[step].translation - start;
      const ContinuedRay direct{.beam = hits_.beamOfRay[i],
                                .origin = sensor + rotation[step] * beams.originOf(i),
                                .direction = rotation[step] * beams.direction[i],
                                .weight = hits_.weightOfRay[i]};
      appendContinuations(direct, hits_, i, continued);
    }
    return continued;
  }

  bool continues(std::uint16_t material) const { return material < continues_.size() && continues_[material] != 0; }

  // Appends the rays that continue from the hit `i` of `ray`. A pane lets a ray pass and a mirror reflects a ray; a
  // surface may be a pane and a mirror. A continued ray that is too weak is not appended.
  void appendContinuations(const ContinuedRay& ray, const Hits& hits, std::uint32_t i,
                           std::vector<ContinuedRay>& continued) const {
    const Material& material = materials_[hits.material[i]];
    const double cosine = hits.incidence[i];
    if (material.transmission > 0 && ray.panes < paths_.panes) {
      const double fraction = paneOf(cosine, material.index, material.transmission).transmitted;
      append(Continuation::ThroughPane, ray, hits.range[i], ray.direction, fraction, continued);
    }
    if (ray.bounces < paths_.bounces) {
      const Vec3d normal(hits.normal[i]);
      const Vec3d reflected = ray.direction - normal * (2 * dot(ray.direction, normal));
      const double fraction = mirrored(material, cosine, hits.reflectance[i]);
      append(Continuation::OffMirror, ray, hits.range[i], normalized(reflected), fraction, continued);
    }
  }

  // Appends the continuation of a ray after its hit at `range` (m), unless the continuation is too weak. `fraction`:
  // fraction of the light that continues.
  void append(Continuation kind, const ContinuedRay& ray, float range, const Vec3d& direction, double fraction,
              std::vector<ContinuedRay>& continued) const {
    const double weight = ray.weight * (fraction * fraction);
    if (weight < paths_.least) return;
    const bool isMirrored = kind == Continuation::OffMirror || ray.path == RayPath::Mirrored;
    continued.push_back({.beam = ray.beam,
                         .origin = ray.origin + ray.direction * double{range} + direction * kStep,
                         .direction = direction,
                         .pathLength = ray.pathLength + (double{range} + kStep),
                         .weight = weight,
                         .panes = ray.panes + (kind == Continuation::ThroughPane ? 1 : 0),
                         .bounces = ray.bounces + (kind == Continuation::OffMirror ? 1 : 0),
                         .path = isMirrored ? RayPath::Mirrored : RayPath::ThroughGlass});
  }

  // Returns a shot whose beams are `rays`, in a single ring. The shot's frame has world axes and its origin at the
  // sensor's position at the start of the revolution. The shot refers to remaining_: it is valid until the next call.
  Shot shotOf(const std::vector<ContinuedRay>& rays) {
    auto table = std::make_shared<BeamTable>();
    table->model = shot_.beams->model;
    table->rings = 1;
    table->columns = static_cast<std::uint32_t>(rays.size());
    table->maxRange = shot_.beams->maxRange;
    table->period = shot_.beams->period;
    table->elevation = {0};
    remaining_.clear();
    for (const ContinuedRay& ray : rays) {
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
    const BeamTable& beams = *shot_.beams;  // a footprint's table has raysPerBeam columns for each beam of a ring
    const std::uint32_t beamColumn = beam % (beams.columns / beams.raysPerBeam);
    return static_cast<float>(beams.columnTime(beamColumn * beams.raysPerBeam));
  }

  // Appends the hits of continued rays to hits_. Returns the rays that continue from these hits.
  std::vector<ContinuedRay> addHits(const std::vector<ContinuedRay>& rays, const Hits& raysHits) {
    std::vector<ContinuedRay> continued;
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
      if (!raysHits.hit(i)) continue;
      const ContinuedRay& ray = rays[i];
      const double pathLength = ray.pathLength + double{raysHits.range[i]};
      if (pathLength > shot_.beams->maxRange) continue;
      if (continues(raysHits.material[i])) appendContinuations(ray, raysHits, i, continued);
      if (pathLength < shot_.beams->minRange) continue;
      hits_.beamOfRay.push_back(ray.beam);
      hits_.weightOfRay.push_back(static_cast<float>(ray.weight));
      hits_.pathOfRay.push_back(ray.path);
      hits_.range.push_back(static_cast<float>(pathLength));
      forEachChannel([&](const ChannelRow& row, auto member) {
        auto& column = hits_.*member;
        if (row.channel != Channel::Range && !column.empty()) column.push_back((raysHits.*member)[i]);
      });
      if (ray.path == RayPath::Mirrored && paths_.mirroredUnlabelled) {
        if (!hits_.semantic.empty()) hits_.semantic.back() = 0;
        if (!hits_.instance.empty()) hits_.instance.back() = 0;
      }
    }
    return continued;
  }

  const Method& method_;
  const Shot& shot_;
  std::span<const Material> materials_;
  const LightPaths& paths_;
  Hits& hits_;
  std::vector<float> remaining_;         // m, by ray of the last shotOf(): the sensor's range minus pathLength
  std::vector<std::uint8_t> continues_;  // by material: 1 if rays continue through or off the material
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
