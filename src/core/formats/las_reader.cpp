#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "formats/readers.h"

namespace scanmill {
namespace {

// Offsets (bytes) in the header, from table 1 of the specification.
constexpr std::size_t kMinor = 25, kHeaderSize = 94, kPointsAt = 96, kFormat = 104, kRecordSize = 105,
                      kLegacyPoints = 107, kScale = 131, kOffset = 155, kPoints = 247;
constexpr std::size_t kLeastHeader = 227;  // size of the header of versions 1.0 to 1.2 (bytes)
constexpr std::array<std::size_t, 11> kLeastRecord{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
constexpr std::array<std::size_t, 11> kGpsTimeAt{0,  20, 0,  20, 20, 20,
                                                 22, 22, 22, 22, 22};  // offset in a record (bytes); 0: none
constexpr std::array<std::size_t, 11> kColorsAt{0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
constexpr std::uint8_t kCompressed = 0x80;

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& what) : bytes_(bytes), where_{what} {}

  Cloud read() {
    if (bytes_.size() < kLeastHeader || !bytes_.starts_with("LASF")) fail("is no LAS file");
    const auto minor = at<std::uint8_t>(kMinor);
    if (at<std::uint8_t>(kMinor - 1) != 1 || minor > 4) {
      fail(fmt::format("is LAS {}.{}: 1.0 to 1.4 are read", at<std::uint8_t>(kMinor - 1), minor));
    }
    format_ = at<std::uint8_t>(kFormat);
    if ((format_ & kCompressed) != 0) {
      fail("is compressed (LAZ): unpack it, by `las2las -i a.laz -o a.las` or `pdal translate a.laz a.las`");
    }
    if (format_ >= kLeastRecord.size()) fail(fmt::format("has the point format {}: 0 to 10 are read", format_));
    record_ = at<std::uint16_t>(kRecordSize);
    if (record_ < kLeastRecord[format_]) {
      fail(fmt::format("has points of {} bytes; format {} has {}", record_, format_, kLeastRecord[format_]));
    }
    std::uint64_t points = at<std::uint32_t>(kLegacyPoints);
    if (minor == 4 && at<std::uint16_t>(kHeaderSize) >= kPoints + 8) {
      if (bytes_.size() < kPoints + 8) fail("is truncated: it ends within its header");
      points = at<std::uint64_t>(kPoints);
    }
    const std::uint64_t first = at<std::uint32_t>(kPointsAt);
    if (first > bytes_.size() || points > (bytes_.size() - first) / record_) {
      fail(fmt::format("is truncated: it announces {} points of {} bytes and has {} bytes for them", points, record_,
                       bytes_.size() - std::min<std::uint64_t>(first, bytes_.size())));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      scale_[axis] = at<double>(kScale + 8 * axis);
      offset_[axis] = at<double>(kOffset + 8 * axis);
      if (!std::isfinite(scale_[axis]) || scale_[axis] == 0 || !std::isfinite(offset_[axis])) {
        fail("has scales or offsets of coordinates that are no numbers");
      }
    }
    readPoints(first, points);
    return std::move(cloud_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(where_, what); }

  template <class T>
  T at(std::uint64_t offset) const {
    T value;
    std::memcpy(&value, bytes_.data() + offset, sizeof(value));
    return value;
  }

  Vec3d placeAt(std::uint64_t record) const {
    std::array<double, 3> place{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = at<std::int32_t>(record + 4 * axis) * scale_[axis] + offset_[axis];
    }
    return {place[0], place[1], place[2]};
  }

  void readPoints(std::uint64_t first, std::uint64_t points) {
    const bool modern = format_ >= 6;
    std::vector<std::uint64_t> records;
    records.reserve(points);
    for (std::uint64_t i = 0; i < points; ++i) {
      const std::uint64_t record = first + i * record_;
      const bool withheld = (at<std::uint8_t>(record + 15) & (modern ? 0x04 : 0x80)) != 0;
      if (!withheld) records.push_back(record);
    }
    if (records.empty()) return;
    cloud_.origin = cloudOrigin(placeAt(records.front()));
    Scan& scan = cloud_.scan;
    for (const std::uint64_t record : records) {
      scan.position.push_back(static_cast<Vec3f>(placeAt(record) - cloud_.origin));
      scan[kIntensity].push_back(at<std::uint16_t>(record + 12));
      const auto classified = at<std::uint8_t>(record + (modern ? 16 : 15));
      scan[kLabel].push_back(modern ? classified : classified & 0x1F);
      scan[kReturn].push_back(at<std::uint8_t>(record + 14) & (modern ? 0x0F : 0x07));
    }
    keep<double>(records, "gps_time", kGpsTimeAt[format_]);
    std::size_t offset = kColorsAt[format_];
    for (const char* name : {"red", "green", "blue"}) {
      keep<std::uint16_t>(records, name, offset);
      offset += offset == 0 ? 0 : 2;
    }
  }

  template <class T>
  void keep(const std::vector<std::uint64_t>& records, const char* name, std::size_t offset) {
    if (offset == 0) return;
    std::vector<T> values;
    values.reserve(records.size());
    for (const std::uint64_t record : records) values.push_back(at<T>(record + offset));
    cloud_.scan.foreign.push_back({name, std::move(values)});
  }

  std::string_view bytes_;
  Location where_;
  std::uint8_t format_ = 0;
  std::uint64_t record_ = 0;  // size of a point (bytes)
  std::array<double, 3> scale_{}, offset_{};
  Cloud cloud_;
};

}  // namespace

Cloud readLas(std::string_view bytes, const std::string& what) {
  return Reader(bytes, what).read();
}

}  // namespace scanmill
