#include "passes/exr/pass_exr.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
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

namespace scanmill {

namespace {

constexpr float kWrittenNoDepth = 1e10f;    // m, depth that is written for a pixel without a surface
constexpr float kLeastNoDepth = 1e9f;       // m; in files, a depth of at least this means a pixel without a surface
constexpr double kFloatIds = 16777216;      // 2^24; float32 cannot represent every integer above it
constexpr std::size_t kExrGrain = 1 << 16;  // pixels per task

// A pass of floats from 0 to `largest`.
struct Parameter {
  const char* name;
  std::vector<float> PassPlanes::*plane;
  float largest;
};
constexpr Parameter kParameters[] = {{"reflectance", &PassPlanes::reflectance, 1},
                                     {"roughness", &PassPlanes::roughness, 1},
                                     {"metallic", &PassPlanes::metallic, 1},
                                     {"retroreflectance", &PassPlanes::retroreflectance, 1e6f}};

// Calls visit(name of the pass, channel of the pass, plane) for each plane of integer ids.
template <class Planes, class Visit>
void forIds(Planes& planes, const Visit& visit) {
  forEachPass([&](const ChannelRow& row, auto plane, auto) {
    if constexpr (std::is_integral_v<typename std::remove_cvref_t<decltype(planes.*plane)>::value_type>) {
      visit(row.name.data(), row.channel, planes.*plane);
    }
  });
}

// Returns the channel `name` or, if there is none, the channel "<layer>.<name>"; null if the file has neither. Throws
// InputError if several layers have such a channel.
const ExrChannel* findInAnyLayer(const ExrReader& file, const std::string& name) {
  if (const ExrChannel* channel = file.find(name)) return channel;
  const ExrChannel* layered = nullptr;
  for (const ExrChannel& channel : file.channels()) {
    if (!channel.name.ends_with("." + name)) continue;
    if (layered != nullptr) {
      throw InputError({file.name()}, "channels '{}' and '{}' could both be meant: keep one, or rename it '{}'",
                       layered->name, channel.name, name);
    }
    layered = &channel;
  }
  return layered;
}

// Returns a channel "<layer>.Z" that is a depth; null if there is none. Skips a channel that is the third component of
// a vector, and names with more levels, such as Blender's "<layer>.Mist.Z".
const ExrChannel* findLayerZ(const ExrReader& file) {
  const auto isDepth = [&](const ExrChannel& channel) {
    if (!channel.name.ends_with(".Z") || channel.name.find('.') != channel.name.size() - 2) return false;
    return file.find(channel.name.substr(0, channel.name.size() - 1) + "X") == nullptr;
  };
  const auto depth = std::ranges::find_if(file.channels(), isDepth);
  return depth == file.channels().end() ? nullptr : &*depth;
}

// Returns the names of the file's first kListed channels, for messages.
std::string channelList(const ExrReader& file) {
  constexpr std::size_t kListed = 24;  // so that the message stays readable
  std::string list;
  for (std::size_t i = 0; i < std::min(file.channels().size(), kListed); ++i) {
    list += (list.empty() ? "" : ", ") + file.channels()[i].name;
  }
  return file.channels().size() > kListed ? list + " ..." : list;
}

[[noreturn]] void refuseAbsence(const ExrReader& file, std::string_view channel, std::string_view remedy) {
  throw InputError({file.name()}, "channel '{}' is absent: write {}; there are {}", channel, remedy, channelList(file));
}

// Returns the channel of a pass ("instance", "reflectance" ...); null if the file has none. Throws InputError if
// several channels could be the pass.
const ExrChannel* findPass(const ExrReader& file, std::string_view pass) {
  std::vector<std::string> names{std::string(pass)};
  if (pass == "instance") names.push_back("IndexOB");
  if (pass == "material") names.push_back("IndexMA");
  for (const std::string& name : names) {
    for (const char* end : {"", ".X", ".V"}) {
      if (const ExrChannel* channel = findInAnyLayer(file, name + end)) return channel;
    }
  }
  return nullptr;
}

// Returns the channels of the normal: N.X, N.Y and N.Z, or Normal.X and so on; three nulls if one of them is absent.
std::array<const ExrChannel*, 3> findNormal(const ExrReader& file) {
  for (const std::string name : {"N.", "Normal."}) {
    const std::array axes{findInAnyLayer(file, name + "X"), findInAnyLayer(file, name + "Y"),
                          findInAnyLayer(file, name + "Z")};
    if (std::none_of(axes.begin(), axes.end(), [](const ExrChannel* c) { return c == nullptr; })) return axes;
  }
  return {};
}

// The functions require...() throw InputError with the file's channels if the pass is absent. Types are not checked.
const ExrChannel& requirePass(const ExrReader& file, std::string_view pass) {
  if (const ExrChannel* channel = findPass(file, pass)) return *channel;
  refuseAbsence(file, pass, fmt::format("the pass '{}'{}", pass, insteadOf(pass)));
}

const ExrChannel& requireDepth(const ExrReader& file) {
  if (const ExrChannel* channel = file.find("Z")) return *channel;
  for (const char* name : {"Depth.Z", "depth.Z"}) {
    if (const ExrChannel* channel = findInAnyLayer(file, name)) return *channel;
  }
  if (const ExrChannel* channel = findLayerZ(file)) return *channel;
  refuseAbsence(file, "Z", "the planar depth as 32 bit FLOAT");
}

// Reads one file. All requested planes are decoded together; then each plane is checked and converted, the depth first,
// because the other planes are zero where the depth shows no surface.
class PassReader {
 public:
  explicit PassReader(const std::filesystem::path& path) : file_(path) {}

  PassImage read(PassChoice requested) {
    image_.camera = readCamera(file_);
    planes_.reset(file_.pixels(), requested);
    decode();
    checkDepth();
    if (!planes_.normal.empty()) checkNormals();
    forIds(planes_, [&](const char* pass, Channel, auto& plane) {
      if (!plane.empty()) convertIds(pass, plane);
    });
    for (const Parameter& parameter : kParameters) {
      if (!(planes_.*parameter.plane).empty()) checkParameter(parameter);
    }
    return std::move(image_);
  }

 private:
  // Decodes the channels of all requested planes: ids into rawIds_, all other values into planes_.
  void decode() {
    std::vector<ExrTarget> targets{depthTarget()};
    if (!planes_.normal.empty()) addNormalTargets(targets);
    forIds(planes_, [&](const char* pass, Channel, auto& plane) {
      if (!plane.empty()) targets.push_back(idTarget(pass));
    });
    for (const Parameter& parameter : kParameters) {
      std::vector<float>& plane = planes_.*parameter.plane;
      if (plane.empty()) continue;
      const ExrChannel& channel = requirePass(file_, parameter.name);
      requireReal(channel);
      targets.push_back({&channel, plane.data(), sizeof(float)});
    }
    file_.read(targets);
  }

  // A plane's ids as the file stores them: integers or, in files of Blender for instance, the bits of floats.
  struct RawIds {
    std::string channel;
    bool areFloats = false;
    std::vector<std::uint32_t> words;

    double idAt(std::size_t pixel) const {
      return areFloats ? double{std::bit_cast<float>(words[pixel])} : words[pixel];
    }
  };

  [[noreturn]] void refuse(const std::string& channel, const std::string& why) const {
    throw InputError({file_.name()}, "channel '{}': {}", channel, why);
  }

  ExrTarget depthTarget() {
    const ExrChannel& channel = requireDepth(file_);
    if (channel.type != ExrType::Float32) {
      refuse(channel.name, fmt::format("is {}: write depth as 32 bit FLOAT{}", exrTypeName(channel.type),
                                       channel.type == ExrType::Float16 ? ", HALF keeps 3 digits" : ""));
    }
    depthName_ = channel.name;
    return {&channel, planes_.depth.data(), sizeof(float)};
  }

  void addNormalTargets(std::vector<ExrTarget>& targets) {
    const auto axes = findNormal(file_);
    if (axes[0] == nullptr) {
      refuseAbsence(file_, "N.X, N.Y, N.Z", fmt::format("the normals, in world axes{}", insteadOf("normal")));
    }
    float* const firstNormal = &planes_.normal.data()->x;  // the components x, y and z follow each other
    for (std::size_t i = 0; i < 3; ++i) {
      requireReal(*axes[i]);
      targets.push_back({axes[i], firstNormal + i, sizeof(Vec3f)});
    }
    normalName_ = axes[0]->name;
  }

  void requireReal(const ExrChannel& channel) const {
    if (channel.type == ExrType::Uint32) refuse(channel.name, "is UINT: write it as FLOAT");
  }

  ExrTarget idTarget(const char* pass) {
    const ExrChannel& channel = requirePass(file_, pass);
    if (channel.type == ExrType::Float16) {
      refuse(channel.name, "is HALF, which is exact only to 2048: write ids as UINT");
    }
    RawIds& raw = rawIds_[pass] = {channel.name, channel.type == ExrType::Float32, {}};
    raw.words.resize(file_.pixels());
    return {&channel, raw.words.data(), sizeof(std::uint32_t)};
  }

  // Calls convert(pixel), which returns false if the pixel's value is invalid, for all pixels, on all cores. If values
  // are invalid, throws InputError for the first one. `problem(pixel)` returns what is wrong with it.
  template <class Convert, class Problem>
  void convertPixels(const std::string& channel, const Convert& convert, const Problem& problem) const {
    std::atomic<std::size_t> firstBad = file_.pixels();
    parallelFor(file_.pixels(), kExrGrain, [&](std::size_t begin, std::size_t end) {
      std::size_t firstBadHere = end;
      for (std::size_t i = begin; i < end; ++i) {
        if (!convert(i) && i < firstBadHere) firstBadHere = i;
      }
      if (firstBadHere == end) return;
      for (std::size_t lowest = firstBad;
           firstBadHere < lowest && !firstBad.compare_exchange_weak(lowest, firstBadHere);) {
      }
    });
    const std::size_t bad = firstBad;
    if (bad == file_.pixels()) return;
    refuse(channel, fmt::format("{} at column {}, row {}", problem(bad), bad % file_.width(), bad / file_.width()));
  }

  bool showsSurface(std::size_t pixel) const { return planes_.depth[pixel] < kNoDepth; }

  void checkDepth() {
    float* const depth = planes_.depth.data();
    const auto convert = [&](std::size_t i) {
      const bool valid = depth[i] > 0;
      if (depth[i] >= kLeastNoDepth) depth[i] = kNoDepth;
      return valid;
    };
    convertPixels(depthName_, convert, [&](std::size_t bad) {
      return fmt::format(
          "a depth of {:g} m (1e10 means that nothing is seen, and it is more than 0 in front of the camera)",
          depth[bad]);
    });
  }

  // Checks that normals are unit vectors, and flips normals that face away from the camera, except normals of edge-on
  // surfaces, whose sign may come from rounding. Normals from writePasses() are therefore never flipped.
  void checkNormals() {
    constexpr double kEdgeOn = 1e-6;  // cosine of the angle of incidence below which a surface counts as edge-on
    // Squared lengths from kShortest2 to kLongest2 are valid. If a squared length differs from 1 by more than
    // kRounding2, which float32 rounding does not explain, the normal is normalised.
    constexpr float kShortest2 = 0.98f, kLongest2 = 1.02f, kRounding2 = 1e-5f;
    const Camera& camera = image_.camera;
    const Mat3 worldFromCamera = toMatrix(camera.worldFromCamera.rotation);
    Vec3f* const normal = planes_.normal.data();
    std::atomic<std::size_t> away = 0;
    const auto convert = [&](std::size_t i) {
      Vec3f& n = normal[i];
      if (!showsSurface(i)) {
        n = {};
        return true;
      }
      const float square = dot(n, n);
      if (!(square > kShortest2 && square < kLongest2)) return false;
      if (std::abs(square - 1) > kRounding2) n = normalized(n);
      const auto row = static_cast<std::uint32_t>(i / camera.width);
      const auto column = static_cast<std::uint32_t>(i % camera.width);
      const Vec3d sight = worldFromCamera * camera.ray(column + 0.5, row + 0.5);
      const double along = dot(Vec3d(n), sight);
      if (along > 0 && along > kEdgeOn * length(sight)) {
        n = -n;
        away.fetch_add(1, std::memory_order_relaxed);
      }
      return true;
    };
    convertPixels(normalName_, convert, [&](std::size_t bad) {
      const auto [x, y, z] = normal[bad];
      return fmt::format("a normal ({:g}, {:g}, {:g}) that is no unit vector (draw it without filter and antialiasing)",
                         x, y, z);
    });
    if (away > 0) refuseMostAway(away);
  }

  // Throws InputError if most normals face away from the camera: wrong camera axes in the file are then more likely
  // than a scene whose surfaces are mostly modelled inside out. `away`: number of normals that face away.
  void refuseMostAway(std::size_t away) const {
    const auto pixels =
        static_cast<std::size_t>(std::ranges::count_if(planes_.depth, [](float z) { return z < kNoDepth; }));
    if (away <= pixels / 2) return;
    refuse(
        normalName_,
        fmt::format("most normals face away from the camera ({} of {} pixels): worldFromCamera must have camera axes "
                    "x right, y down, z forward; from OpenGL's or Blender's (y up, z backward) negate its second and "
                    "third column. If it is right, turn the normals towards the camera",
                    away, pixels));
  }

  // Fills `plane` with the ids that decode() has stored in rawIds_.
  template <class Id>
  void convertIds(const char* pass, std::vector<Id>& plane) {
    const RawIds raw = std::move(rawIds_[pass]);
    double largest = std::numeric_limits<Id>::max();
    if (raw.areFloats) largest = std::min(largest, kFloatIds - 1);
    Id* const ids = plane.data();
    const auto convert = [&](std::size_t i) {
      const double value = raw.idAt(i);
      const bool valid = value >= 0 && value <= largest && value == std::floor(value);
      ids[i] = valid && showsSurface(i) ? static_cast<Id>(value) : Id{0};
      return valid;
    };
    convertPixels(raw.channel, convert, [&](std::size_t bad) {
      return fmt::format("an id of {:g}: it must be a whole number from 0 to {:.0f}{}", raw.idAt(bad), largest,
                         raw.areFloats ? " (write ids as UINT, without filter and antialiasing)" : "");
    });
  }

  void checkParameter(const Parameter& parameter) {
    float* const values = (planes_.*parameter.plane).data();
    const auto convert = [&](std::size_t i) {
      if (!showsSurface(i)) values[i] = 0;
      return values[i] >= 0 && values[i] <= parameter.largest;
    };
    convertPixels(findPass(file_, parameter.name)->name, convert, [&](std::size_t bad) {
      return fmt::format("a value of {:g}: it must be 0 to {:g}", values[bad], parameter.largest);
    });
  }

  ExrReader file_;
  PassImage image_;
  PassPlanes& planes_ = image_.planes;
  std::string depthName_;                 // name of the depth's channel; decode() sets this and the members below
  std::string normalName_;                // name of the first of the normal's channels
  std::map<std::string, RawIds> rawIds_;  // by pass
};

}  // namespace

void writePasses(const std::filesystem::path& path, const PassImage& image) {
  const PassPlanes& passes = image.planes;
  std::vector<ExrPlane> planes;
  // Adds a channel with the values of `pass` from `data` on, `stride` bytes apart, unless the pass is empty.
  const auto add = [&](const char* channel, ExrType type, const auto& pass, const void* data, std::size_t stride) {
    if (pass.empty()) return;
    if (pass.size() != image.camera.pixels()) {
      throw Error("{}: the pass '{}' has {} pixels, its camera {} x {}", path.string(), channel, pass.size(),
                  image.camera.width, image.camera.height);
    }
    planes.push_back({channel, type, data, stride});
  };
  std::vector<float> depth(passes.depth);
  if (depth.empty()) throw Error("{}: an image without depth cannot be written", path.string());
  for (float& z : depth) z = z < kLeastNoDepth ? z : kWrittenNoDepth;
  add("Z", ExrType::Float32, depth, depth.data(), sizeof(float));
  for (std::size_t axis = 0; axis < 3 && !passes.normal.empty(); ++axis) {
    constexpr const char* kAxes[] = {"N.X", "N.Y", "N.Z"};
    add(kAxes[axis], ExrType::Float32, passes.normal, &passes.normal.data()->x + axis, sizeof(Vec3f));
  }
  std::vector<std::vector<std::uint32_t>> widened;  // copies of 16-bit ids: OpenEXR has only 32-bit integers
  forIds(passes, [&]<class Id>(const char* name, Channel, const std::vector<Id>& plane) {
    const void* words = plane.data();
    if constexpr (sizeof(Id) < sizeof(std::uint32_t)) words = widened.emplace_back(plane.begin(), plane.end()).data();
    add(name, ExrType::Uint32, plane, words, sizeof(std::uint32_t));
  });
  for (const Parameter& parameter : kParameters) {
    add(parameter.name, ExrType::Float32, passes.*parameter.plane, (passes.*parameter.plane).data(), sizeof(float));
  }
  ExrAttributes attributes = cameraAttributes(image.camera);
  attributes["writer"] = fmt::format("Scanmill {}", kVersion);
  writeExr(path, image.camera.width, image.camera.height, attributes, planes, ExrCompression::Zip);
}

PassImage readPasses(const std::filesystem::path& path, PassChoice requested) {
  return PassReader(path).read(requested);
}

PassChoice passesIn(const std::filesystem::path& path) {
  const ExrReader file(path);
  PassChoice present;
  if (findNormal(file)[0] != nullptr) present.channels |= Channel::Normal;
  const PassPlanes noPlanes;
  forIds(noPlanes, [&](const char* pass, Channel channel, const auto&) {
    if (findPass(file, pass) != nullptr) present.channels |= channel;
  });
  if (findPass(file, "reflectance") != nullptr) present.channels |= Channel::Reflectance;
  // The first parameter is the reflectance, which is not a surface parameter.
  present.surfaceParameters = std::all_of(std::begin(kParameters) + 1, std::end(kParameters),
                                          [&](const Parameter& p) { return findPass(file, p.name) != nullptr; });
  return present;
}

}  // namespace scanmill
