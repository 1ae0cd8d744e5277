#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "base/text_scan.h"
#include "config/text.h"
#include "formats/little_endian.h"
#include "formats/readers.h"
#include "formats/text_rows.h"
#include "rasters/raster.h"

namespace scanmill {
namespace {

// Offsets (bytes) in the header, from table 1 of the specification.
constexpr std::size_t kEncoding = 6, kMinor = 25, kHeaderSize = 94, kPointsAt = 96, kRecords = 100, kFormat = 104,
                      kRecordSize = 105, kLegacyPoints = 107, kScale = 131, kOffset = 155, kWaveformsAt = 227,
                      kLaterRecordsAt = 235, kLaterRecords = 243, kPoints = 247;
// Types of extra bytes, which the specification numbers from 1: kind (unsigned, signed, float) and size (bytes).
constexpr std::string_view kExtraKinds = "UIUIUIUIFF";
constexpr std::array<std::uint64_t, 10> kExtraBytes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
constexpr std::uint16_t kWktBit = 1 << 4;  // bit of the global encoding: well-known text states the coordinate system
constexpr ColumnKey<columnIndex("returns")> kReturns;
constexpr std::size_t kLeastHeader = 227;  // size of the header of versions 1.0 to 1.2 (bytes)
constexpr std::array<std::size_t, 11> kLeastRecord{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
// Offsets in a point's record (bytes), by point format; 0: the format lacks the field.
constexpr std::array<std::size_t, 11> kGpsTimeAt{0, 20, 0, 20, 20, 20, 22, 22, 22, 22, 22};
constexpr std::array<std::size_t, 11> kColorsAt{0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
constexpr std::uint8_t kCompressed = 0x80;

// Names of the classes 0 to 22, from table 17 of the specification of LAS 1.4.
constexpr std::string_view kClassNames =
    "never classified|unclassified|ground|low vegetation|medium vegetation|high vegetation|building|low noise|"
    "key point|water|rail|road surface|overlap|wire guard|wire conductor|transmission tower|wire connector|"
    "bridge deck|high noise|overhead structure|ignored ground|snow|temporal exclusion";

class LasReader {
 public:
  LasReader(std::string_view bytes, const std::string& what) : bytes_(bytes), where_{what} {
    std::vector<std::string_view> names;
    splitCells(kClassNames, '|', names);
    for (std::uint32_t k = 0; k < names.size(); ++k) cloud_.classNames[k] = names[k];
  }

  // Checks the header, then reads the records of the coordinate system and of the extra bytes, then the points.
  Cloud read(CloudUnit unit) {
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
    recordBytes_ = at<std::uint16_t>(kRecordSize);
    if (recordBytes_ < kLeastRecord[format_]) {
      fail(fmt::format("has points of {} bytes; format {} has {}", recordBytes_, format_, kLeastRecord[format_]));
    }
    if (bytes_.size() < at<std::uint16_t>(kHeaderSize)) fail("is truncated: it ends within its header");
    points_ = at<std::uint32_t>(kLegacyPoints);
    if (minor == 4 && at<std::uint16_t>(kHeaderSize) >= kPoints + 8) points_ = at<std::uint64_t>(kPoints);
    first_ = at<std::uint32_t>(kPointsAt);
    if (first_ > bytes_.size() || points_ > (bytes_.size() - first_) / recordBytes_) {
      fail(fmt::format("is truncated: it announces {} points of {} bytes and has {} bytes for them", points_,
                       recordBytes_, bytes_.size() - std::min<std::uint64_t>(first_, bytes_.size())));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      scale_[axis] = at<double>(kScale + 8 * axis);
      offset_[axis] = at<double>(kOffset + 8 * axis);
      if (!std::isfinite(scale_[axis]) || scale_[axis] == 0 || !std::isfinite(offset_[axis])) {
        fail("has scales or offsets of coordinates that are no numbers");
      }
    }
    readRecords();
    if (unit == CloudUnit::OfFile) applyUnit();
    readPoints();
    cloud_.leftOut.add("points behind the announced ones", (endOfPoints() - first_) / recordBytes_ - points_);
    return std::move(cloud_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(where_, what); }

  template <class T>
  T at(std::uint64_t offset) const {
    return numberAt<T>(bytes_, offset);
  }

  // Returns the position (m) of the point whose record begins at the byte `record`.
  Vec3d positionAt(std::uint64_t record) const {
    std::array<double, 3> position{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = (at<std::int32_t>(record + 4 * axis) * scale_[axis] + offset_[axis]) * metres_[axis];
    }
    return {position[0], position[1], position[2]};
  }

  // Reads the records between the header and the points and, in LAS 1.4, those behind the points.
  void readRecords() {
    readRecordsAt<std::uint16_t>(at<std::uint16_t>(kHeaderSize), first_, at<std::uint32_t>(kRecords));
    if (at<std::uint8_t>(kMinor) < 4 || at<std::uint16_t>(kHeaderSize) < kPoints) return;
    readRecordsAt<std::uint64_t>(at<std::uint64_t>(kLaterRecordsAt), bytes_.size(), at<std::uint32_t>(kLaterRecords));
  }

  // Reads up to `count` records in the bytes [begin, end). `Length`: type of the field with the length of the data.
  template <class Length>
  void readRecordsAt(std::uint64_t begin, std::uint64_t end, std::uint32_t count) {
    constexpr std::uint64_t kHead = 52 + sizeof(Length);  // size of a record's header (bytes)
    for (; count > 0 && begin <= end && end - begin >= kHead; --count) {
      const std::uint64_t length = at<Length>(begin + 20);
      if (length > end - begin - kHead) break;
      readRecord(begin, bytes_.substr(begin + kHead, length));
      begin += kHead + length;
    }
  }

  // Returns the offset (bytes) where the points end at the latest: where the next records begin, or the file's end.
  std::uint64_t endOfPoints() const {
    const int minor = at<std::uint8_t>(kMinor);
    std::uint64_t end = bytes_.size();
    for (const std::uint64_t field : {kWaveformsAt, kLaterRecordsAt}) {
      if (minor < (field == kWaveformsAt ? 3 : 4) || at<std::uint16_t>(kHeaderSize) < field + 8) continue;
      if (const auto begin = at<std::uint64_t>(field); begin >= first_) end = std::min(end, begin);
    }
    return end;
  }

  // Keeps the data of a record that is used, or counts the record as left out. `begin`: the record's offset (bytes).
  void readRecord(std::uint64_t begin, std::string_view data) {
    const std::string_view user = textAt(bytes_, begin + 2, 16);
    const auto id = at<std::uint16_t>(begin + 18);
    if (user == "LASF_Projection" && id == 2112) wkt_ = data;
    if (user == "LASF_Projection" && id == 34735) geoKeys_ = data;
    if (user == "LASF_Projection" && id == 34736) geoNumbers_ = data;
    if (user == "LASF_Projection" && id == 34737) geoTexts_ = data;
    if (user == "LASF_Spec" && id == 4) described_ = data;
    if (user == "liblas" && id == 2112) wkt_ = data;
    const bool isWaveform = user == "LASF_Spec" && id >= 100;
    if (user.starts_with("LASF_") && !isWaveform) cloud_.leftOut.addKeyword(kLasFormat, fmt::format("{}/{}", user, id));
    if (user != "LASF_Spec" || id != 0) return;
    for (std::size_t k = 0; k + 16 <= data.size(); k += 16) {
      const std::string name(textAt(data, k + 1, 15));
      if (!name.empty()) cloud_.classNames[static_cast<unsigned char>(data[k])] = name;
    }
  }

  // Returns a field of `length` bytes as text, up to its first zero byte.
  static std::string_view textAt(std::string_view data, std::size_t begin, std::size_t length) {
    const std::string_view field = data.substr(begin, length);
    return field.substr(0, field.find('\0'));
  }

  // Returns the coordinate system at a point, from the well-known text (`byWkt`) or the keys of GeoTIFF. Sets
  // `description` to the source, for messages. If the system cannot be read, returns an empty system, and sets
  // `description` to the reason.
  CoordinateSystem readSystem(bool byWkt, const Vec3d& point, std::string& description) const {
    try {
      description = byWkt ? quotedForMessage(textAt(wkt_, 0, 60)) : "keys of GeoTIFF";
      return byWkt ? coordinateSystem(textAt(wkt_, 0, wkt_.size()), point.x, point.y)
                   : coordinateSystem({geoKeys_, geoNumbers_, geoTexts_}, point.x, point.y);
    } catch (const Error& e) {
      description = e.what();
      return {};
    }
  }

  // Sets metres_ and Cloud::system from the coordinate system at the first point, and warns if the system cannot be
  // read, is not in metres or stretches lengths. Throws InputError if coordinates are not lengths.
  void applyUnit() {
    if (wkt_.empty() && geoKeys_.empty()) return;
    const bool byWkt = !wkt_.empty() && ((at<std::uint16_t>(kEncoding) & kWktBit) != 0 || geoKeys_.empty());
    std::string description;
    // metres_ is still 1, so the position is in the file's own units, as readSystem() needs.
    const CoordinateSystem system = readSystem(byWkt, points_ == 0 ? Vec3d{} : positionAt(first_), description);
    constexpr const char* kReproject =
        "reproject it, by `pdal translate a.las b.las reprojection --filters.reprojection.out_srs=EPSG:32632` with the "
        "zone of the place";
    if (system.geographic || !system.foreign.empty()) {
      fail(fmt::format("has {}: {}, or state the metres per unit by the key `unit`, which goes before the file",
                       system.foreign.empty() ? "coordinates in degrees" : system.foreign, kReproject));
    }
    const double vertical = system.perHeight.value_or(system.perUnit);
    metres_ = {system.perUnit, system.perUnit, vertical};
    // From keys of GeoTIFF that name no known system, GDAL makes a local system.
    const bool isKnown = !system.definition.empty() && (byWkt || !system.local);
    if (!isKnown) {
      warn(
          "{}: its coordinate system cannot be read ({}), and counts as in units of {:.10g} m: give the key "
          "`unit` if it is not",
          where_.file, description, system.perUnit);
    } else if (system.perUnit != 1 || vertical != 1) {
      warn(
          "{}: its coordinates, in units of {:.10g} m ({}), and {}, in units of {:.10g} m, become "
          "metres; the key `unit` would go before the file",
          where_.file, system.perUnit, system.unit, vertical < 0 ? "depths, which become heights below 0" : "heights",
          std::fabs(vertical));
    }
    cloud_.system = system.definition;
    if (system.isStretched()) {
      warn(
          "{}: lengths in its coordinate system are {:.4g} times those on the ground (in Mercator projections "
          "1/cos(latitude)), heights are not: {}",
          where_.file, system.stretch, kReproject);
    }
  }

  // Returns the offset (bytes) of the record of each point that is not marked as withheld.
  std::vector<std::uint64_t> recordsOfPoints() {
    std::vector<std::uint64_t> records;
    records.reserve(points_);
    for (std::uint64_t i = 0; i < points_; ++i) {
      const std::uint64_t record = first_ + i * recordBytes_;
      const bool withheld = hasFlags() && (at<std::uint8_t>(record + 15) & (isModern() ? 0x04 : 0x80)) != 0;
      if (!withheld) records.push_back(record);
    }
    cloud_.leftOut.add("points marked as withheld", points_ - records.size());
    return records;
  }

  bool isModern() const { return format_ >= 6; }                  // formats of LAS 1.4
  bool hasFlags() const { return at<std::uint8_t>(kMinor) > 0; }  // LAS 1.0 has classes of 8 bits and no flags

  void readPoints() {
    const std::vector<std::uint64_t> records = recordsOfPoints();
    if (!records.empty()) cloud_.origin = cloudOrigin(positionAt(records.front()));
    Scan& scan = cloud_.scan;
    std::vector<std::uint16_t> labels;
    std::vector<float> intensities;
    for (const std::uint64_t record : records) {  // fields of a record: tables 7 and 13 of the specification
      scan.position.push_back(static_cast<Vec3f>(positionAt(record) - cloud_.origin));
      intensities.push_back(at<std::uint16_t>(record + 12));
      const auto classBits = at<std::uint8_t>(record + (isModern() ? 16 : 15));
      labels.push_back(isModern() || !hasFlags() ? classBits : classBits & 0x1F);
      const auto returnBits = at<std::uint8_t>(record + 14);
      scan[kReturn].push_back(returnBits & (isModern() ? 0x0F : 0x07));
      scan[kReturns].push_back(isModern() ? returnBits >> 4 : returnBits >> 3 & 0x07);
    }
    scan.columnsIfEmpty = ColumnSet(kReturn, kReturns);
    addForeign<double>(records, "gps_time", kGpsTimeAt[format_]);
    std::size_t offset = kColorsAt[format_];
    for (const char* name : {"red", "green", "blue"}) {
      addForeign<std::uint16_t>(records, name, offset);
      offset += offset == 0 ? 0 : 2;
    }
    readExtraBytes(records);
    chooseIntensities(std::move(intensities));
    chooseLabels(std::move(labels));
  }

  // Sets the column `intensity` to the exact intensities that our exports have as extra bytes, else to `intensities`.
  void chooseIntensities(std::vector<float> intensities) {
    std::vector<ForeignColumn>& foreign = cloud_.scan.foreign;
    const auto exact = std::ranges::find(foreign, kLasExactIntensity, &ForeignColumn::name);
    if (exact != foreign.end()) return void(exact->name = kIntensity.row.name);
    cloud_.scan[kIntensity] = std::move(intensities);
    cloud_.scan.columnsIfEmpty.add(kIntensity.index);
  }

  // Sets the column label to `labels`. If all labels are 0, uses the labels in extra bytes instead, if there are any.
  void chooseLabels(std::vector<std::uint16_t> labels) {
    Scan& scan = cloud_.scan;
    const bool classified = std::ranges::any_of(labels, [](std::uint16_t label) { return label != 0; });
    if (classified) scan[kLabel] = labels;
    adoptColumns(cloud_, {});  // without a location, columns that do not fit are counted as left out
    if (!classified && scan.has(kLabel)) {
      cloud_.classNames.clear();
    } else if (!classified) {
      scan[kLabel] = std::move(labels);
      scan.columnsIfEmpty.add(kLabel.index);
    }
  }

  // Adds a foreign column for each field of extra bytes that described_ describes.
  void readExtraBytes(const std::vector<std::uint64_t>& records) {
    constexpr std::size_t kDescription = 192;
    std::uint64_t firstByte = kLeastRecord[format_];
    for (; described_.size() >= kDescription; described_.remove_prefix(kDescription)) {
      const std::string name(textAt(described_, 4, 32));
      const std::size_t type = static_cast<unsigned char>(described_[2]);
      const std::size_t options = static_cast<unsigned char>(described_[3]);
      // For type 0 (undocumented bytes), `options` is the number of bytes. Types from 11 on are pairs and triples of
      // the first ten (LAS 1.4, table of extra bytes).
      const std::uint64_t size =
          type == 0 ? options : kExtraBytes[(type - 1) % kExtraBytes.size()] * ((type - 1) / 10 + 1);
      if (size > recordBytes_ - firstByte) break;
      if (type == 0 || type > kExtraBytes.size()) {
        cloud_.leftOut.add(fmt::format("extra bytes '{}' of several values", name));
      } else {
        visitNumberType(kExtraKinds[type - 1], kExtraBytes[type - 1],
                        [&]<class T>(T) { addExtra<T>(records, name, firstByte, options); });
      }
      firstByte += size;
    }
    cloud_.leftOut.add("bytes of each point that nothing describes", recordBytes_ - firstByte);
  }

  // Adds the extra bytes at `firstByte` of each record as a foreign column. Their description is at the start of
  // described_. `options`: its bits say whether the field has a no-data value, a scale and an offset.
  template <class T>
  void addExtra(const std::vector<std::uint64_t>& records, const std::string& name, std::uint64_t firstByte,
                std::size_t options) {
    constexpr std::size_t kHasNone = 1, kHasScale = 8, kHasOffset = 16;
    addForeign<T>(records, name, firstByte);
    auto& values = std::get<std::vector<T>>(cloud_.scan.foreign.back().values);
    if ((options & kHasNone) != 0 && columnIndex(columnMeant(name)) < kColumnCount) {
      const T none =
          std::is_same_v<T, float> ? static_cast<T>(numberAt<double>(described_, 40)) : numberAt<T>(described_, 40);
      std::ranges::replace(values, none, T{});
    }
    if ((options & (kHasScale | kHasOffset)) == 0) return;
    const double scale = (options & kHasScale) != 0 ? numberAt<double>(described_, 112) : 1;
    const double offset = (options & kHasOffset) != 0 ? numberAt<double>(described_, 136) : 0;
    std::vector<double> scaled;
    scaled.reserve(values.size());
    for (const T value : values) scaled.push_back(static_cast<double>(value) * scale + offset);
    cloud_.scan.foreign.back().values = std::move(scaled);
  }

  // Adds the numbers at `offset` in each record as a foreign column. Adds nothing if `offset` is 0.
  template <class T>
  void addForeign(const std::vector<std::uint64_t>& records, const std::string& name, std::uint64_t offset) {
    if (offset == 0) return;
    std::vector<T> values;
    values.reserve(records.size());
    for (const std::uint64_t record : records) values.push_back(at<T>(record + offset));
    cloud_.scan.foreign.push_back({name, std::move(values)});
  }

  std::string_view bytes_;
  Location where_;
  std::uint8_t format_ = 0;
  std::uint64_t recordBytes_ = 0;         // size of a point (bytes)
  std::uint64_t first_ = 0, points_ = 0;  // offset of the first point (bytes), number of points
  std::array<double, 3> scale_{}, offset_{}, metres_{1, 1, 1};
  std::string_view wkt_, geoKeys_, geoNumbers_, geoTexts_;  // records of the coordinate system
  std::string_view described_;                              // descriptions of the extra bytes that are not read yet
  Cloud cloud_;
};

}  // namespace

const FormatSupport kLasFormat{
    "LAS",
    ".las",
    "Coordinates in double precision; feet of the coordinate system become metres, depths become heights. "
    "Intensities, of which intensity_f of our own exports goes first; classes, with the names of the specification "
    "or of the file, or from extra bytes if all are 0; returns, times and colours; extra bytes as columns of point "
    "clouds. Flags, angles, near infrared and waveforms change nothing",
    "points marked as withheld; points behind the announced ones; points of classes of noise, unless `points.labels` "
    "is given; extra bytes of several values or without a description",
    {.read = {"LASF_Spec/0 LASF_Spec/4 LASF_Projection/2112 LASF_Projection/34735 LASF_Projection/34736",
              "LASF_Projection/34737 liblas/2112"},
     .unused = {"LASF_Spec/2 LASF_Spec/3 LASF_Spec/7"},
     .leftOut = {{"LASF_Projection/2111", "transforms of coordinates (LASF_Projection/2111)"}}}};

Cloud readLas(std::string_view bytes, const std::string& what, CloudUnit unit) {
  return LasReader(bytes, what).read(unit);
}

}  // namespace scanmill
