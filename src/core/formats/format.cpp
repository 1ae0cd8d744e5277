#include "formats/format.h"

#include <algorithm>
#include <array>

#include "formats/readers.h"

namespace scanmill {

std::span<const FormatEntry> formats() {
  static constexpr std::array<FormatEntry, 3> kFormats{{
      {"pcd", "pcd", "PCD 0.7 of the Point Cloud Library, lossless",
       "encoding: binary_compressed, how points are stored: binary_compressed, binary (fastest to read) or ascii",
       makePcd},
      {"draco", "drc",
       "Draco, positions within max_error_mm, incidences within 0.1 mrad and ids exact, misses left out; time only "
       "where asked for, as it follows from ring and column",
       "max_error_mm: 1 mm, largest error of a position, 0.001 to 1000\n"
       "speed: 7, 0 (smallest file) to 10 (fastest)\n"
       "time: false, true: keeps the time of each point",
       makeDraco},
      {"csv", "csv", "comma-separated text with a header line, lossless", "", makeCsv},
  }};
  return kFormats;
}

const FormatEntry& requireFormat(std::string_view name, const Location& where) {
  return requireNamed(formats(), "format", name, where);
}

const FormatEntry* formatBySuffix(std::string_view suffix) {
  const auto entry = std::ranges::find(formats(), suffix, &FormatEntry::suffix);
  return entry == formats().end() ? nullptr : &*entry;
}

}  // namespace scanmill
