#pragma once

// The table of the columns that a point of a scan may have besides its position. Each column is defined only here: all
// code that writes, reads, checks, plans, describes or colours columns iterates over this table. To add a column, add a
// row here and the lines in sense/gather.cpp that fill it. This header is installed because scan/scan.h includes it.
//
//   const ColumnSet columns = ColumnSet::byDefault().with(kRangeTrue).without(kTime);

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "scan/channels.h"

namespace scanmill {

enum class ColumnType : std::uint8_t { Float32, UInt8, UInt16, UInt32 };

// The error that a format with bounded errors (Draco) may add to a column. Integers are always exact.
enum class ColumnLoss : std::uint8_t {
  Exact,
  AsPositions,  // an error of at most the format's largest error of positions
  Bounded,      // an error of at most Column::lossBound
};

// The condition that valid values of a column meet.
enum class ColumnValidity : std::uint8_t {
  Any,
  Finite,       // finite numbers, also for points without a value
  Rings,        // integers below the sensor's number of rings
  Columns,      // integers below the sensor's number of columns
  SensorRange,  // metres within the sensor's range limits
  Interval,     // from Column::low to Column::high, or NaN
};

enum class ColumnColors : std::uint8_t {
  Classes,    // each value is a class of the ontology
  Instances,  // each value has its own colour; 0 is grey
  Scale,      // a colour map from the least to the greatest value
};

// How values are shown to people: as numbers (`factor` times the stored value, in `unit`) and as colours.
struct ColumnDisplay {
  std::string_view title{};  // title of the colour legend; empty: the column's name
  std::string_view unit{};
  double factor = 1;
  int decimals = -1;  // -1: five significant digits
  ColumnColors colors = ColumnColors::Scale;
  double scalePower = 1;         // the colour map's position t shows the value low + (high - low) * t^scalePower
  double scaleClipped = 0;       // fraction of the values that are cut off at each end of the scale
  bool scaleOfValidity = false;  // true: the scale is Column::low to Column::high; false: the least to the greatest
                                 // value
  char key = 0;                  // the viewer's key that colours by this column; 0: none
  bool inReport = false;         // true: a dataset's report has an image coloured by this column
};

struct Column {
  std::string_view name;  // name in files and in the key output.columns
  ColumnType type;
  std::string_view unit{};   // unit of the stored values; empty: no unit
  std::string_view meaning;  // a phrase without a full stop
  double none = 0;           // value that marks a point without a value, such as a miss in an organised scan
  Channels channels{};       // channels of Hits that the column is computed from
  bool byDefault = true;     // true: written if the pipeline does not name output.columns
  ColumnLoss loss = ColumnLoss::Exact;
  double lossBound = 0;  // largest error of a lossy format, in `unit`
  ColumnValidity validity = ColumnValidity::Any;
  double low = 0;  // bounds for ColumnValidity::Interval
  double high = 0;
  ColumnDisplay display{};
};

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Returns the row of a column about the motion of the object that a beam hits.
constexpr Column motionColumn(std::string_view name, std::string_view unit, Channels channels,
                              std::string_view meaning) {
  return {.name = name,
          .type = ColumnType::Float32,
          .unit = unit,
          .meaning = meaning,
          .channels = channels,
          .byDefault = false,
          .validity = ColumnValidity::Finite,
          .display = {.unit = unit, .decimals = 3}};
}

// Returns the row of a column that holds an angle of the noise-free point, from -limit to limit (rad).
constexpr Column angleColumn(std::string_view name, double limit, std::string_view meaning) {
  return {.name = name,
          .type = ColumnType::Float32,
          .unit = "rad",
          .meaning = meaning,
          .none = kNoNumber,
          .channels = Channel::Range,
          .byDefault = false,
          .loss = ColumnLoss::Bounded,
          .lossBound = 1e-5,  // 1 mm at 100 m
          .validity = ColumnValidity::Interval,
          .low = -limit,
          .high = limit,
          .display = {.unit = "deg", .factor = 180 / kPi, .decimals = 3}};
}

// The columns in the order in which files store them, after x, y and z.
inline constexpr auto kColumns = std::to_array<Column>({
    {.name = "intensity",
     .type = ColumnType::Float32,
     .meaning = "strength of the return, up to the full scale that the effect `intensity` states",
     .validity = ColumnValidity::Finite,
     .display = {.scalePower = 2, .scaleClipped = 0.01, .key = '2', .inReport = true}},
    {.name = "label",
     .type = ColumnType::UInt16,
     .meaning = "class id of the ontology",
     .channels = Channel::Semantic,
     .display = {.title = "class", .colors = ColumnColors::Classes, .key = '1'}},
    {.name = "instance",
     .type = ColumnType::UInt32,
     .meaning = "id of the thing; 0: none",
     .channels = Channel::Instance,
     .display = {.colors = ColumnColors::Instances, .key = '3'}},
    {.name = "ring",
     .type = ColumnType::UInt16,
     .meaning = "row of the beam, as the sensor numbers its lasers or elevations",
     .validity = ColumnValidity::Rings,
     .display = {.key = '5', .inReport = true}},
    {.name = "column",
     .type = ColumnType::UInt16,
     .meaning = "column of the beam; column 0 fires first",
     .validity = ColumnValidity::Columns},
    {.name = "time",
     .type = ColumnType::Float32,
     .unit = "s",
     .meaning = "time since the start of the revolution",
     .validity = ColumnValidity::Finite,
     .display = {.unit = "ms", .factor = 1e3, .decimals = 4, .key = '6'}},
    {.name = "range_true",
     .type = ColumnType::Float32,
     .unit = "m",
     .meaning = "noise-free range, from where the beam starts; with `footprint` that of the return's strongest ray",
     .none = kNoNumber,
     .byDefault = false,
     .loss = ColumnLoss::AsPositions,
     .validity = ColumnValidity::SensorRange,
     .display = {.unit = "m", .decimals = 4, .scalePower = 2, .scaleClipped = 0.01}},
    {.name = "incidence",
     .type = ColumnType::Float32,
     .unit = "rad",
     .meaning = "angle between the beam and the normal of the surface: 0 head-on, pi/2 grazing",
     .none = kNoNumber,
     .channels = Channel::Incidence,
     .byDefault = false,
     .loss = ColumnLoss::Bounded,
     .lossBound = 1e-4,  // 0.006 deg; the float32 cosine of a small angle is itself exact to 0.35 mrad only
     .validity = ColumnValidity::Interval,
     .low = 0,
     .high = kPi / 2,
     .display =
         {.unit = "deg", .factor = 180 / kPi, .decimals = 3, .scaleOfValidity = true, .key = '9', .inReport = true}},
    {.name = "return",
     .type = ColumnType::UInt8,
     .meaning = "number of the beam's return, 1 the nearest; 0: none",
     .byDefault = false,
     .display = {.key = '8'}},
    {.name = "cause",
     .type = ColumnType::UInt8,
     .meaning =
         "what the return comes from: 1 a surface of the scene, 2 nothing (a false positive), 3 a surface behind "
         "glass, 4 a mirror image, 5 the own vehicle, 6 rain, snow, fog or dust, 7 stray light; 0: none",
     .byDefault = false},
    angleColumn("azimuth", kPi,
                "where the noise-free point lies as seen from the sensor's origin, from x towards y; the offset of the "
                "beam's origin is taken in"),
    angleColumn("elevation", kPi / 2,
                "where the noise-free point lies as seen from the sensor's origin, above its xy plane; the offset of "
                "the beam's origin is taken in"),
    {.name = "returns",
     .type = ColumnType::UInt8,
     .meaning = "how many returns the beam has; 0: none",
     .byDefault = false},
    {.name = "label_2",
     .type = ColumnType::UInt16,
     .meaning = "class id of what gives most of the return's power besides the label's class; 0: nothing does",
     .channels = Channel::Semantic,
     .byDefault = false,
     .display = {.colors = ColumnColors::Classes}},
    {.name = "share",
     .type = ColumnType::Float32,
     .meaning = "part of the return's power that comes from the label's class",
     .none = kNoNumber,
     .channels = Channel::Semantic,
     .byDefault = false,
     .loss = ColumnLoss::Bounded,
     .lossBound = 1e-3,
     .validity = ColumnValidity::Interval,
     .low = 0,
     .high = 1,
     .display = {.decimals = 3, .scaleOfValidity = true}},
    {.name = "power",
     .type = ColumnType::Float32,
     .meaning = "power that the receiver measures, uncorrected, with the lasers' own gains and speckle: 1 is a white "
                "target, met head-on, at the reference range of the effect `intensity`",
     .byDefault = false,
     .validity = ColumnValidity::Finite,
     .display = {.decimals = 4, .scalePower = 2, .scaleClipped = 0.01}},
    motionColumn("velocity_x", "m/s", Channel::Instance,
                 "velocity over ground of the thing that the beam meets, along the sensor's x axis; 0: "
                 "it stands, or is no thing"),
    motionColumn("velocity_y", "m/s", Channel::Instance, "likewise along the y axis"),
    motionColumn("velocity_z", "m/s", Channel::Instance, "likewise along the z axis"),
    motionColumn("flow_x", "m", Channel::Instance | Channel::Primitive,
                 "scene flow: how far what the beam meets moves over ground until the next frame, along the sensor's x "
                 "axis; 0: it stands, or is no thing"),
    motionColumn("flow_y", "m", Channel::Instance | Channel::Primitive, "likewise along the y axis"),
    motionColumn("flow_z", "m", Channel::Instance | Channel::Primitive, "likewise along the z axis"),
    {.name = "radial_velocity",
     .type = ColumnType::Float32,
     .unit = "m/s",
     .meaning = "how fast the distance between sensor and surface grows, as FMCW sensors measure it, without noise; "
                "negative: they approach; NaN: a mirror image, or no surface",
     .none = kNoNumber,
     .channels = Channel::Instance,
     .byDefault = false,
     .validity = ColumnValidity::Interval,
     .low = -1e4,
     .high = 1e4,
     .display = {.unit = "m/s", .decimals = 3}},
    {.name = "normal_oct",
     .type = ColumnType::UInt32,
     .meaning =
         "unit normal of the surface, turned towards the sensor, along the axes of the points, octahedral (x in the "
         "low 16 bits, exact to 0.004 deg; `Scan.normals` in Python); 0: a mirror image, the own vehicle, or no "
         "surface",
     .channels = Channel::Normal,
     .byDefault = false,
     .display = {.colors = ColumnColors::Instances}},
});

inline constexpr std::size_t kColumnCount = kColumns.size();

// Returns true if the column depends on how the scene's objects move.
constexpr bool dependsOnMotion(const Column& column) {
  return column.name.starts_with("velocity_") || column.name.starts_with("flow_") || column.name == "radial_velocity";
}

// Returns the index of a column in the table; kColumnCount if no column has that name.
constexpr std::size_t columnIndex(std::string_view name) {
  std::size_t index = 0;
  while (index < kColumnCount && kColumns[index].name != name) ++index;
  return index;
}

// The C++ type of the values of a column in a scan.
template <ColumnType type>
using ColumnValue =
    std::tuple_element_t<static_cast<std::size_t>(type), std::tuple<float, std::uint8_t, std::uint16_t, std::uint32_t>>;

// Names a row of the table and the type of its values at compile time: scan[kLabel] is a std::vector<std::uint16_t>.
template <std::size_t Index>
struct ColumnKey {
  static_assert(Index < kColumnCount, "the table of columns has no row of this name");
  static constexpr std::size_t index = Index;
  static constexpr const Column& row = kColumns[Index];
  using Value = ColumnValue<kColumns[Index].type>;
};

// Keys of the columns that code accesses by name.
inline constexpr ColumnKey<columnIndex("intensity")> kIntensity;
inline constexpr ColumnKey<columnIndex("label")> kLabel;
inline constexpr ColumnKey<columnIndex("instance")> kInstance;
inline constexpr ColumnKey<columnIndex("ring")> kRing;
inline constexpr ColumnKey<columnIndex("column")> kColumn;
inline constexpr ColumnKey<columnIndex("time")> kTime;
inline constexpr ColumnKey<columnIndex("range_true")> kRangeTrue;
inline constexpr ColumnKey<columnIndex("incidence")> kIncidence;
inline constexpr ColumnKey<columnIndex("return")> kReturn;
inline constexpr ColumnKey<columnIndex("cause")> kCause;
inline constexpr ColumnKey<columnIndex("power")> kPower;

// Calls visit() with the ColumnKey of every row of kColumns, in the order of kColumns.
template <class Visit>
constexpr void forEachColumn(Visit&& visit) {
  [&]<std::size_t... Index>(std::index_sequence<Index...>) {
    (visit(ColumnKey<Index>{}), ...);
  }
  (std::make_index_sequence<kColumnCount>());
}

// Returns the type's name: "float32", "uint8", "uint16" or "uint32".
std::string_view nameOf(ColumnType type);

constexpr std::size_t bytesOf(ColumnType type) {
  return type == ColumnType::UInt8 ? 1 : type == ColumnType::UInt16 ? 2 : 4;
}

// A set of columns, which are rows of the table kColumns.
class ColumnSet {
 public:
  constexpr ColumnSet() = default;
  template <std::size_t... Index>
  constexpr explicit ColumnSet(ColumnKey<Index>... keys) {
    (add(keys.index), ...);
  }
  static constexpr ColumnSet all() {
    ColumnSet set;
    for (std::size_t i = 0; i < kColumnCount; ++i) set.add(i);
    return set;
  }
  // Returns the columns that are written if the pipeline has no key output.columns.
  static constexpr ColumnSet byDefault() {
    ColumnSet set;
    for (std::size_t i = 0; i < kColumnCount; ++i) {
      if (kColumns[i].byDefault) set.add(i);
    }
    return set;
  }

  constexpr bool has(std::size_t index) const { return (bits_ >> index & 1) != 0; }
  template <std::size_t Index>
  constexpr bool has(ColumnKey<Index>) const {
    return has(Index);
  }
  constexpr ColumnSet& add(std::size_t index) {
    bits_ |= std::uint64_t{1} << index;
    return *this;
  }
  constexpr ColumnSet& remove(std::size_t index) {
    bits_ &= ~(std::uint64_t{1} << index);
    return *this;
  }
  template <std::size_t Index>
  [[nodiscard]] constexpr ColumnSet with(ColumnKey<Index>) const {
    return ColumnSet(*this).add(Index);
  }
  template <std::size_t Index>
  [[nodiscard]] constexpr ColumnSet without(ColumnKey<Index>) const {
    return ColumnSet(*this).remove(Index);
  }
  constexpr bool operator==(const ColumnSet&) const = default;

  // Returns the channels of Hits that the columns are computed from.
  constexpr Channels channels() const {
    Channels needed;
    for (std::size_t i = 0; i < kColumnCount; ++i) {
      if (has(i)) needed |= kColumns[i].channels;
    }
    return needed;
  }
  // Returns the columns' names, in the order of the table.
  std::vector<std::string> names() const;

 private:
  static_assert(kColumnCount <= 64);
  std::uint64_t bits_ = 0;
};

// Selects the columns of a scan, whether it is organised (with misses), and whether it has the reasons of beams.
struct ScanLayout {
  ColumnSet columns = ColumnSet::byDefault();
  bool organised = false;
  bool reasons = false;  // true: Scan::reasonOfBeam is filled
};

// Returns the names of all columns of a scan as its files list them: "x", "y", "z" and then `columns`.
std::vector<std::string> scanColumnNames(ColumnSet columns);

// Returns a text followed by its unit in brackets, such as "time (s)"; only the text if the unit is empty.
[[nodiscard]] std::string withUnit(std::string_view text, std::string_view unit);

// Returns a stored value as text for users, formatted as Column::display says: "3.1416 ms", "12", "45.000 deg".
std::string displayText(const Column& column, double value);

}  // namespace scanmill
