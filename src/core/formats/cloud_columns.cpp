#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "config/text.h"
#include "formats/readers.h"
#include "formats/text_rows.h"

namespace scanmill {

namespace {

// Converts stored numbers to values of a column. Replaces labels and instances that mean "none": see adoptColumns().
template <class Key, class Stored>
std::vector<typename Key::Value> columnValues(Key key, const std::vector<Stored>& stored, const Location& where) {
  using Value = typename Key::Value;
  std::vector<Value> values;
  values.reserve(stored.size());
  const bool isLabel = key.index == kLabel.index;
  const auto isNone = [&](Stored number) {
    if (!std::is_signed_v<Stored> || (!isLabel && key.index != kInstance.index)) return false;
    constexpr int kIgnored = -100;  // a label that the losses of PyTorch ignore by default
    return isLabel ? number == static_cast<Stored>(-1) || number == static_cast<Stored>(kIgnored) : number < Stored{};
  };
  const bool countFrom1 = !isLabel && std::ranges::any_of(stored, isNone);
  const bool hasZero = isLabel && std::ranges::find(stored, Stored{}) != stored.end();
  const Value none = hasZero ? std::numeric_limits<Value>::max() : Value{};
  for (const Stored number : stored) {
    const std::size_t point = values.size();
    Value value = isNone(number) ? none : columnValue<Value>(number, key.row.name, point, where);
    if (countFrom1 && !isNone(number))
      value = columnValue<Value>(static_cast<double>(value) + 1, key.row.name, point, where);
    values.push_back(value);
  }
  return values;
}

}  // namespace

const FormatSupport kCloudColumns{
    "Columns of point clouds",
    ".las, .ply, .pcd, .csv, .xyz, .drc",
    "Classes: points without a class have the number 0, -1 or -100; -1 and -100 become 0, or 65535 if the file has "
    "the number 0 too. Instances: 0 means none or, if there are numbers below 0, these do, and all others increase by "
    "1. "
    "A column of intensities that are all 0 is replaced by another. Rings, numbers and counts of returns, of recorded "
    "scans. Colours, also packed as PCL does (rgb, rgba), and normals",
    "points at 0, 0, 0, if there are several: misses; colours that are no numbers",
    {.read =
         {"label labels label_id class classes class_id class_label classification category category_id semantic "
          "semantics semantic_label semantic_id sem_class sem_label objtag object_tag predsemantic pred_label",
          "instance instances instance_id instanceid instance_label inst_id treeid tree_id predinstance pred_instance "
          "objidx object_id objectid obj_id",
          "intensity intensities reflectance reflectivity remission",
          "ring ring_id ring_index laser_id laserid beam_id channel line", "return return_number returnnumber",
          "returns number_of_returns numberofreturns num_returns", "red r diffuse_red", "green g diffuse_green",
          "blue b diffuse_blue", "rgb rgba", "nx normal_x", "ny normal_y", "nz normal_z"},
     .unused = {"alpha a curvature cosangle confidence range near_ir ambient noise signal",
                "gps_time gpstime timestamp t time_offset offset_time scan_angle scan_angle_rank scan_direction_flag "
                "edge_of_flight_line user_data point_source_id pointsourceid scanner_channel"}}};

std::string columnMeant(std::string_view name) {
  constexpr std::string_view kPrefix = "scalar_";  // before names of columns in files of CloudCompare
  std::string plainName = lowerCase(name);
  if (plainName.starts_with(kPrefix)) plainName.erase(0, kPrefix.size());
  for (const std::string_view names : kCloudColumns.keywords.read) {
    if (containsWord(names, plainName)) return std::string(names.substr(0, names.find(' ')));
  }
  return plainName;
}

void adoptColumns(Cloud& cloud, const Location& where) {
  Scan& scan = cloud.scan;
  for (const bool hasOwnName : {true, false}) {  // first columns with the table's names, then columns with other names
    // Erases the foreign columns that were copied into the scan's table. A foreign column is copied into the table's
    // column that its name stands for, unless the scan already has this column.
    std::erase_if(scan.foreign, [&](const ForeignColumn& column) {
      const std::string meant = columnMeant(column.name);
      if (hasOwnName != (lowerCase(column.name) == meant)) return false;
      bool adopted = false;
      visitTable(scan, [&](auto key, auto& values) {
        if (key.row.name != meant) return;
        // Scanners that do not measure intensities write 0, so a column of zeros counts as absent.
        const bool isZero = key.index == kIntensity.index && std::ranges::count(values, 0) == std::ssize(values);
        if (scan.has(key) && !isZero) return;
        try {
          std::visit([&](const auto& stored) { values = columnValues(key, stored, hasOwnName ? where : Location{}); },
                     column.values);
          scan.columnsIfEmpty.add(key.index);
          adopted = true;
        } catch (const InputError& error) {
          if (hasOwnName && !where.file.empty()) throw;
          cloud.leftOut.add(fmt::format("columns '{}' ({})", column.name, error.what()));
        }
      });
      return adopted;
    });
  }
}

void setPositions(const std::vector<Vec3d>& exact, Cloud& cloud) {
  const auto finite = std::ranges::find_if(exact, [](const Vec3d& p) { return isFinite(p); });
  cloud.origin = finite == exact.end() ? Vec3d{} : cloudOrigin(*finite);
  cloud.scan.position.clear();
  cloud.scan.position.reserve(exact.size());
  for (const Vec3d& p : exact) cloud.scan.position.push_back(static_cast<Vec3f>(p - cloud.origin));
}

}  // namespace scanmill
