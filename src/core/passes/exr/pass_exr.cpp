#include "passes/exr/pass_exr.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <type_traits>

#include "base/error.h"
#include "base/parallel.h"
#include "config/version.h"
#include "passes/exr/exr_file.h"
#include "passes/exr/pass_channels.h"

namespace scanmill {

namespace {

constexpr float kWrittenNoDepth = 1e10f;    // m, depth that is written for a pixel without a surface
constexpr float kNothing = 1e9f;            // m; in files, a depth of at least this means a pixel without a surface
constexpr double kFloatIds = 16777216;      // 2^24; float32 cannot represent every integer above it
constexpr std::size_t kExrGrain = 1 << 16;  // pixels per task

struct Parameter {
  const char* name;
  std::vector<float> PassPlanes::*plane;
  float most;
};
constexpr Parameter kParameters[] = {{"reflectance", &PassPlanes::reflectance, 1},
                                     {"roughness", &PassPlanes::roughness, 1},
                                     {"metallic", &PassPlanes::metallic, 1},
                                     {"retroreflectance", &PassPlanes::retroreflectance, 1e6f}};

// Calls use(name of the pass, channel of the pass, plane) for each plane of integer ids.
template <class Planes, class Use>
void forIds(Planes& planes, const Use& use) {
  forEachPass([&](const ChannelRow& row, auto plane, auto) {
    if constexpr (std::is_integral_v<typename std::remove_cvref_t<decltype(planes.*plane)>::value_type>) {
      use(row.name.data(), row.channel, planes.*plane);
    }
  });
}

class PassReader {
 public:
  PassReader(const std::filesystem::path& path, PassChoice asked) : file_(path), asked_(asked) {}

  PassImage read() {
    image_.camera = readCamera(file_);
    planes_.reset(file_.pixels(), asked_);
    targetDepth();
    if (!planes_.normal.empty()) targetNormal();
    forIds(planes_, [&](const char* name, Channel, auto& plane) {
      if (!plane.empty()) targetIds(name);
    });
    for (const Parameter& parameter : kParameters) {
      if (!(planes_.*parameter.plane).empty()) targetParameter(parameter.name, planes_.*parameter.plane);
    }
    file_.read(targets_);

    finishDepth();
    if (!planes_.normal.empty()) finishNormal();
    forIds(planes_, [&](const char* name, Channel, auto& plane) {
      if (!plane.empty()) finishIds(name, plane);
    });
    for (const Parameter& parameter : kParameters) {
      if (!(planes_.*parameter.plane).empty()) finishParameter(parameter);
    }
    return std::move(image_);
  }

 private:
  // A plane's ids as the file stores them: integers, or the bits of floats, as Blender writes them.
  struct RawIds {
    std::string channel;
    bool real = false;
    std::vector<std::uint32_t> words;

    double at(std::size_t pixel) const { return real ? double{std::bit_cast<float>(words[pixel])} : words[pixel]; }
  };

  [[noreturn]] void refuse(const std::string& channel, const std::string& why) const {
    throw InputError({file_.name()}, fmt::format("channel '{}': {}", channel, why));
  }

  [[noreturn]] void refusePixel(const std::string& channel, std::size_t pixel, const std::string& why) const {
    refuse(channel, fmt::format("{} at column {}, row {}", why, pixel % file_.width(), pixel / file_.width()));
  }

  void targetDepth() {
    const ExrChannel& channel = requireDepth(file_);
    if (channel.type != ExrType::Float32) {
      refuse(channel.name, fmt::format("is {}: write depth as 32 bit FLOAT{}", exrTypeName(channel.type),
                                       channel.type == ExrType::Float16 ? ", HALF keeps 3 digits" : ""));
    }
    depthName_ = channel.name;
    targets_.push_back({&channel, planes_.depth.data(), sizeof(float)});
  }

  void targetNormal() {
    const auto axes = requireNormal(file_);
    float* const first = &planes_.normal.data()->x;
    for (std::size_t i = 0; i < 3; ++i) {
      requireReal(*axes[i]);
      targets_.push_back({axes[i], first + i, sizeof(Vec3f)});
    }
    normalName_ = axes[0]->name;
  }

  void requireReal(const ExrChannel& channel) const {
    if (channel.type == ExrType::Uint32) refuse(channel.name, "is UINT: write it as FLOAT");
  }

  void targetIds(const char* pass) {
    const ExrChannel& channel = requirePass(file_, pass);
    if (channel.type == ExrType::Float16) {
      refuse(channel.name, "is HALF, which is exact only to 2048: write ids as UINT");
    }
    RawIds& raw = raw_[pass] = {channel.name, channel.type == ExrType::Float32, {}};
    raw.words.resize(file_.pixels());
    targets_.push_back({&channel, raw.words.data(), sizeof(std::uint32_t)});
  }

  void targetParameter(const char* pass, std::vector<float>& plane) {
    const ExrChannel& channel = requirePass(file_, pass);
    requireReal(channel);
    targets_.push_back({&channel, plane.data(), sizeof(float)});
  }

  // Calls work(pixel) for all pixels. Returns the first pixel for which `work` returns false, or the number of pixels
  // if `work` returns true for all.
  template <class Work>
  std::size_t forPixels(const Work& work) const {
    std::atomic<std::size_t> bad = file_.pixels();
    parallelFor(file_.pixels(), kExrGrain, [&](std::size_t first, std::size_t last) {
      std::size_t found = last;
      for (std::size_t i = first; i < last; ++i) {
        if (!work(i) && i < found) found = i;
      }
      if (found == last) return;
      for (std::size_t known = bad; found < known && !bad.compare_exchange_weak(known, found);) {
      }
    });
    return bad;
  }

  bool seen(std::size_t pixel) const { return planes_.depth[pixel] < kNoDepth; }

  void finishDepth() {
    float* const depth = planes_.depth.data();
    const std::size_t bad = forPixels([&](std::size_t i) {
      const bool good = depth[i] > 0;
      if (depth[i] >= kNothing) depth[i] = kNoDepth;
      return good;
    });
    if (bad < file_.pixels()) {
      refusePixel(
          depthName_, bad,
          fmt::format("a depth of {:g} m (1e10 means that nothing is seen, and it is more than 0 in front of the "
                      "camera)",
                      planes_.depth[bad]));
    }
  }

  // Checks that normals are unit vectors, and flips normals that face away from the camera, except those of edge-on
  // surfaces, whose sign may come from rounding. Normals from writePasses() are therefore never flipped.
  void finishNormal() {
    constexpr double kEdgeOn = 1e-6;  // cosine of the angle of incidence below which a surface counts as edge-on
    const Camera& camera = image_.camera;
    const Mat3 worldFromCamera = toMatrix(camera.worldFromCamera.rotation);
    Vec3f* const normal = planes_.normal.data();
    std::atomic<std::size_t> away = 0;
    const std::size_t bad = forPixels([&](std::size_t i) {
      Vec3f& n = normal[i];
      if (!seen(i)) {
        n = {};
        return true;
      }
      const float square = dot(n, n);
      if (!(square > 0.98f && square < 1.02f)) return false;
      if (std::abs(square - 1) > 1e-5f) n = normalized(n);
      const auto row = static_cast<std::uint32_t>(i / camera.width);
      const auto column = static_cast<std::uint32_t>(i % camera.width);
      const Vec3d sight = worldFromCamera * camera.ray(column + 0.5, row + 0.5);
      const double along = dot(Vec3d(n), sight);
      if (along > 0 && along > kEdgeOn * length(sight)) {
        n = -n;
        away.fetch_add(1, std::memory_order_relaxed);
      }
      return true;
    });
    if (bad < file_.pixels()) {
      const Vec3f& n = planes_.normal[bad];
      refusePixel(normalName_, bad,
                  fmt::format("a normal ({:g}, {:g}, {:g}) that is no unit vector (draw it without filter and "
                              "antialiasing)",
                              n.x, n.y, n.z));
    }
    if (away > 0) refuseMostAway(away);
  }

  // Throws InputError if most normals face away from the camera (`away`: their number). A file with wrong camera axes
  // is then more likely than a scene whose surfaces are mostly modelled inside out.
  void refuseMostAway(std::size_t away) const {
    const auto& depth = planes_.depth;
    const auto pixels =
        static_cast<std::size_t>(std::count_if(depth.begin(), depth.end(), [](float z) { return z < kNoDepth; }));
    if (away <= pixels / 2) return;
    refuse(
        normalName_,
        fmt::format("most normals face away from the camera ({} of {} pixels): worldFromCamera must have camera axes "
                    "x right, y down, z forward; from OpenGL's or Blender's (y up, z backward) negate its second and "
                    "third column. If it is right, turn the normals towards the camera",
                    away, pixels));
  }

  template <class Id>
  void finishIds(const char* pass, std::vector<Id>& plane) {
    const RawIds raw = std::move(raw_[pass]);
    double most = std::numeric_limits<Id>::max();
    if (raw.real) most = std::min(most, kFloatIds - 1);
    Id* const ids = plane.data();
    const std::size_t bad = forPixels([&](std::size_t i) {
      const double value = raw.at(i);
      const bool good = value >= 0 && value <= most && value == std::floor(value);
      ids[i] = good && seen(i) ? static_cast<Id>(value) : Id{0};
      return good;
    });
    if (bad < file_.pixels()) {
      refusePixel(raw.channel, bad,
                  fmt::format("an id of {:g}: it must be a whole number from 0 to {:.0f}{}", raw.at(bad), most,
                              raw.real ? " (write ids as UINT, without filter and antialiasing)" : ""));
    }
  }

  void finishParameter(const Parameter& parameter) {
    float* const values = (planes_.*parameter.plane).data();
    const std::size_t bad = forPixels([&](std::size_t i) {
      if (!seen(i)) values[i] = 0;
      return values[i] >= 0 && values[i] <= parameter.most;
    });
    if (bad < file_.pixels()) {
      refusePixel(findPass(file_, parameter.name)->name, bad,
                  fmt::format("a value of {:g}: it must be 0 to {:g}", values[bad], parameter.most));
    }
  }

  ExrReader file_;
  PassChoice asked_;
  PassImage image_;
  PassPlanes& planes_ = image_.planes;
  std::vector<ExrTarget> targets_;
  std::string depthName_;
  std::string normalName_;
  std::map<std::string, RawIds> raw_;
};

}  // namespace

void writePasses(const std::filesystem::path& path, const PassImage& image) {
  const PassPlanes& from = image.planes;
  const std::size_t pixels = image.camera.pixels();
  std::vector<ExrPlane> planes;
  const auto add = [&](const char* channel, ExrType type, const auto& plane, const void* data, std::size_t stride) {
    if (plane.empty()) return;
    if (plane.size() != pixels) {
      throw Error(fmt::format("{}: the pass '{}' has {} pixels, its camera {} x {}", path.string(), channel,
                              plane.size(), image.camera.width, image.camera.height));
    }
    planes.push_back({channel, type, data, stride});
  };
  std::vector<float> depth(from.depth);
  if (depth.empty()) throw Error(fmt::format("{}: an image without depth cannot be written", path.string()));
  for (float& z : depth) z = z < kNothing ? z : kWrittenNoDepth;
  add("Z", ExrType::Float32, depth, depth.data(), sizeof(float));
  for (std::size_t axis = 0; axis < 3 && !from.normal.empty(); ++axis) {
    constexpr const char* kAxes[] = {"N.X", "N.Y", "N.Z"};
    add(kAxes[axis], ExrType::Float32, from.normal, &from.normal.data()->x + axis, sizeof(Vec3f));
  }
  std::vector<std::vector<std::uint32_t>> wide;  // the planes of 16-bit ids: OpenEXR has only 32-bit integers
  forIds(from, [&](const char* name, Channel, const auto& plane) {
    if constexpr (sizeof plane[0] == sizeof(std::uint32_t)) {
      add(name, ExrType::Uint32, plane, plane.data(), sizeof(std::uint32_t));
    } else {
      wide.emplace_back(plane.begin(), plane.end());
      add(name, ExrType::Uint32, plane, wide.back().data(), sizeof(std::uint32_t));
    }
  });
  for (const Parameter& parameter : kParameters) {
    add(parameter.name, ExrType::Float32, from.*parameter.plane, (from.*parameter.plane).data(), sizeof(float));
  }
  ExrAttributes attributes = cameraAttributes(image.camera);
  attributes["writer"] = fmt::format("Scanmill {}", kVersion);
  writeExr(path, image.camera.width, image.camera.height, attributes, planes, ExrCompression::Zip);
}

PassImage readPasses(const std::filesystem::path& path, PassChoice asked) {
  return PassReader(path, asked).read();
}

PassChoice passesIn(const std::filesystem::path& path) {
  const ExrReader file(path);
  PassChoice there;
  if (findNormal(file)[0] != nullptr) there.channels |= Channel::Normal;
  const PassPlanes none;
  forIds(none, [&](const char* name, Channel channel, const auto&) {
    if (findPass(file, name) != nullptr) there.channels |= channel;
  });
  if (findPass(file, "reflectance") != nullptr) there.channels |= Channel::Reflectance;
  there.surfaceParameters = std::all_of(std::begin(kParameters) + 1, std::end(kParameters),
                                        [&](const Parameter& p) { return findPass(file, p.name) != nullptr; });
  return there;
}

}  // namespace scanmill
