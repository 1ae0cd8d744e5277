#include "passes/exr/hits_exr.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <map>

#include "base/error.h"
#include "config/version.h"
#include "passes/exr/exr_file.h"

namespace scanmill {

namespace {

template <class T>
constexpr ExrType kTypeOf = ExrType::Uint32;
template <>
constexpr ExrType kTypeOf<float> = ExrType::Float32;

// Calls visit(name of the channel in the file, array of `hits`) for each channel with one number per beam.
template <class AnyHits, class Visit>
void forColumns(AnyHits& hits, const Visit& visit) {
  forEachChannel([&](const ChannelRow& row, auto member) {
    if constexpr (!std::is_same_v<decltype(member), std::vector<Vec3f> Hits::*>) visit(row.exr.data(), hits.*member);
  });
  visit("roughness", hits.roughness);
  visit("metallic", hits.metallic);
  visit("retroreflectance", hits.retroreflectance);
}

constexpr const char* kUnresolved = "unresolved";
constexpr const char* kNormal[] = {"N.X", "N.Y", "N.Z"};

// Reads one file: decodes all channels together, then checks them. Columns of 16-bit values are converted from words_.
class HitsReader {
 public:
  HitsReader(const std::filesystem::path& path, Hits& hits) : file_(path), hits_(hits) {}

  void read(Channels requested) {
    hits_.reset(file_.height(), file_.width(), requested);
    if (file_.find("roughness") && file_.find("metallic") && file_.find("retroreflectance")) {
      for (auto* column : {&hits_.roughness, &hits_.metallic, &hits_.retroreflectance}) column->resize(hits_.size());
    }
    forColumns(hits_, [&](const char* name, auto& column) {
      if (!column.empty()) addTarget(name, column);
    });
    for (std::size_t axis = 0; axis < 3 && !hits_.normal.empty(); ++axis) {
      targets_.push_back({&require(kNormal[axis], ExrType::Float32), &hits_.normal.data()->x + axis, sizeof(Vec3f)});
    }
    if (file_.find(kUnresolved) != nullptr) {
      words_[kUnresolved].resize(hits_.size());
      targets_.push_back({&require(kUnresolved, ExrType::Uint32), words_[kUnresolved].data(), sizeof(std::uint32_t)});
    }
    file_.read(targets_);
    checkRange();
    listUnresolved();
    narrow("semantic", hits_.semantic);
    narrow("material", hits_.material);
  }

 private:
  [[noreturn]] void refuse(const char* channel, const std::string& why) const {
    throw InputError({file_.name()}, "channel '{}': {}", channel, why);
  }

  const ExrChannel& require(const char* name, ExrType type) const {
    const ExrChannel* channel = file_.find(name);
    if (channel == nullptr) {
      refuse(name, "is absent, but the pipeline needs it: keep the hits of a pipeline that needs it too");
    }
    if (channel->type != type) {
      refuse(name, fmt::format("is {}, but must be {}", exrTypeName(channel->type), exrTypeName(type)));
    }
    return *channel;
  }

  template <class T>
  void addTarget(const char* name, std::vector<T>& column) {
    void* pixels = column.data();
    if constexpr (sizeof(T) < sizeof(std::uint32_t)) {
      words_[name].resize(hits_.size());
      pixels = words_[name].data();
    }
    targets_.push_back({&require(name, kTypeOf<T>), pixels, sizeof(std::uint32_t)});
  }

  void checkRange() const {
    const auto bad = std::ranges::find_if(hits_.range, [](float range) { return !(range >= 0); });
    if (bad == hits_.range.end()) return;
    const auto beam = static_cast<std::size_t>(bad - hits_.range.begin());
    refuse("range", fmt::format("is {:g} m at ring {}, column {}: it must be at least 0, and infinite for a miss", *bad,
                                beam / hits_.columns, beam % hits_.columns));
  }

  // Fills hits_.unresolved with the beams that the channel "unresolved" marks by 1.
  void listUnresolved() {
    const auto marks = words_.find(kUnresolved);
    if (marks == words_.end()) return;
    for (std::uint32_t beam = 0; beam < marks->second.size(); ++beam) {
      const std::uint32_t mark = marks->second[beam];
      if (mark == 0) continue;
      const auto position = fmt::format("at ring {}, column {}", beam / hits_.columns, beam % hits_.columns);
      if (mark != 1) refuse(kUnresolved, fmt::format("is {} {}: it must be 0 or 1", mark, position));
      if (hits_.hit(beam)) {
        refuse(kUnresolved,
               fmt::format("is 1 {}, where the range is {:g} m: it must be infinite", position, hits_.range[beam]));
      }
      hits_.unresolved.push_back(beam);
    }
  }

  // Fills a column of 16-bit values with the channel's 32-bit values.
  void narrow(const char* name, std::vector<std::uint16_t>& column) const {
    if (column.empty()) return;
    const std::vector<std::uint32_t>& words = words_.at(name);
    for (std::size_t i = 0; i < column.size(); ++i) {
      if (words[i] > std::numeric_limits<std::uint16_t>::max()) {
        refuse(name, fmt::format("an id of {}: it must be at most 65535", words[i]));
      }
      column[i] = static_cast<std::uint16_t>(words[i]);
    }
  }

  ExrReader file_;
  Hits& hits_;
  std::map<std::string, std::vector<std::uint32_t>> words_;  // by channel: uint32 values that need a conversion
  std::vector<ExrTarget> targets_;
};

}  // namespace

Channels channelsIn(const std::filesystem::path& path) {
  const ExrReader file(path);
  Channels present = Channel::Range;
  for (const ChannelRow& row : kChannels) {
    if (file.find(row.exr) != nullptr) present |= row.channel;
  }
  return present;
}

void writeHits(const std::filesystem::path& path, const Hits& hits) {
  std::vector<ExrPlane> planes;
  const auto checkSize = [&](const char* name, std::size_t size) {
    if (size == hits.size()) return;
    throw Error("{}: the column '{}' has {} entries, not {} x {}", path.string(), name, size, hits.rings, hits.columns);
  };
  std::map<std::string, std::vector<std::uint32_t>> words;  // by channel: 32-bit copies of columns of 16-bit values
  forColumns(hits, [&]<class T>(const char* name, const std::vector<T>& column) {
    if (column.empty()) return;
    checkSize(name, column.size());
    const void* pixels = column.data();
    if constexpr (sizeof(T) < sizeof(std::uint32_t)) {
      pixels = words.emplace(name, std::vector<std::uint32_t>(column.begin(), column.end())).first->second.data();
    }
    planes.push_back({name, kTypeOf<T>, pixels, sizeof(std::uint32_t)});
  });
  if (!hits.normal.empty()) {
    checkSize("normal", hits.normal.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      planes.push_back({kNormal[axis], ExrType::Float32, &hits.normal.data()->x + axis, sizeof(Vec3f)});
    }
  }
  if (!hits.unresolved.empty()) {
    std::vector<std::uint32_t>& marks = words[kUnresolved];
    marks.resize(hits.size());
    for (const std::uint32_t beam : hits.unresolved) marks.at(beam) = 1;
    planes.push_back({kUnresolved, ExrType::Uint32, marks.data(), sizeof(std::uint32_t)});
  }
  writeExr(path, hits.columns, hits.rings, {{"units", "m"}, {"writer", fmt::format("Scanmill {}", kVersion)}}, planes,
           ExrCompression::None);
}

void readHits(const std::filesystem::path& path, Channels requested, Hits& hits) {
  HitsReader(path, hits).read(requested);
}

}  // namespace scanmill
