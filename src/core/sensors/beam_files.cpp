#include "sensors/beam_files.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "base/file.h"
#include "base/format_support.h"
#include "config/fields.h"
#include "config/text.h"
#include "sensors/text_table.h"

namespace scanmill {
namespace {

// Returns a name in lower case, reduced to letters, digits and underscores: "Laser id" gives "laserid", "fire time(us)"
// gives "firetimeus". The letter mu (U+03BC or U+00B5) becomes u.
std::string plainName(std::string_view name) {
  std::string plain;
  for (const char c : lowerCase(name)) {
    if (('a' <= c && c <= 'z') || ('0' <= c && c <= '9') || c == '_') plain += c;
    if (c == '\xBC' || c == '\xB5') plain += 'u';
  }
  return plain;
}

// Returns true if a line is a checksum: some of Hesai's files end with one.
bool isChecksum(std::string_view text) {
  return text.size() >= 32 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos;
}

// A table with one row per laser. If it has a column of channel numbers, its rows may be in any order.
class BeamTableFile {
 public:
  explicit BeamTableFile(const std::filesystem::path& file) : bytes_(readFile(file)) {
    const std::vector<TextLine> lines = linesOf(bytes_, file);
    head_ = lines.front();
    for (const std::string_view name : cellsOf(head_.text)) names_.push_back(plainName(name));
    while (!names_.empty() && names_.back().empty()) names_.pop_back();
    for (std::size_t i = 1; i < lines.size(); ++i) {
      std::vector<std::string_view> cells = cellsOf(lines[i].text);
      if (std::all_of(cells.begin(), cells.end(), [](std::string_view c) { return c.empty(); })) continue;
      if (i + 1 == lines.size() && isChecksum(cells.front())) continue;
      while (cells.size() > names_.size() && cells.back().empty()) cells.pop_back();
      rows_.push_back({lines[i].where, std::move(cells)});
    }
    if (rows_.empty()) throw InputError(head_.where, "the table has no line after the column names");
  }

  const TextLine& head() const { return head_; }

  std::optional<std::size_t> column(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      const auto found = std::find(names_.begin(), names_.end(), name);
      if (found == names_.end()) continue;
      if (std::find(found + 1, names_.end(), name) != names_.end()) {
        throw InputError(head_.where, fmt::format("the column '{}' is listed twice", name));
      }
      return static_cast<std::size_t>(found - names_.begin());
    }
    return std::nullopt;
  }

  // Throws InputError if the table has a column that is not in `known`; the message suggests a similar known name.
  void expectOnly(const std::vector<std::string>& known) const {
    for (const std::string& name : names_) {
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      throw InputError(head_.where, fmt::format("the column '{}' is unknown{}", name, suggestion(name, known)));
    }
  }

  // Returns the numbers of a column in the order of the channels, or of the lines if the table has no channels.
  // Channels are numbered from 1, or from 0 if the table has a channel 0.
  std::vector<double> numbers(std::size_t column, Range range = {}) const {
    const auto channels = this->column({"channel", "laserid", "laser_id", "ring"});
    for (const Row& row : rows_) {
      if (row.cells.size() == names_.size()) continue;
      throw InputError(row.where,
                       fmt::format("has {} cells, but the first line has {}", row.cells.size(), names_.size()));
    }
    std::vector<double> numbers(rows_.size());
    std::vector<bool> known(rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      std::size_t at = i;
      if (channels) {
        const double channel = numberOf(row.cells[*channels], row.where);
        const double least = hasZero(*channels) ? 0 : 1;
        if (channel != std::floor(channel) || channel < least || channel - least >= static_cast<double>(rows_.size())) {
          throw InputError(row.where,
                           fmt::format("has the channel {:g}, but a table of {} lines has the channels {:g} to {:g}",
                                       channel, rows_.size(), least, least + static_cast<double>(rows_.size()) - 1));
        }
        at = static_cast<std::size_t>(channel - least);
      }
      if (known[at]) throw InputError(row.where, "has the channel of an earlier line: give each channel one line");
      known[at] = true;
      numbers[at] = numberOf(row.cells[column], row.where);
      if (numbers[at] >= range.low && numbers[at] <= range.high) continue;
      throw InputError(row.where, fmt::format("{} is {:g}, but must be from {:g} to {:g}", names_[column], numbers[at],
                                              range.low, range.high));
    }
    return numbers;
  }

 private:
  struct Row {
    Location where;
    std::vector<std::string_view> cells;
  };

  bool hasZero(std::size_t channels) const {
    return std::any_of(rows_.begin(), rows_.end(),
                       [&](const Row& row) { return numberOf(row.cells[channels], row.where) == 0; });
  }

  std::string bytes_;
  TextLine head_;
  std::vector<std::string> names_;
  std::vector<Row> rows_;
};

}  // namespace

const FormatSupport& beamTableFormat() {
  static const FormatSupport format{
      "Table of lasers",
      ".csv",
      {},
      "Hesai's angle correction file (Channel, Elevation, Azimuth in degrees, clockwise) and firetime correction file, "
      "with one firing state; or a table of your own with elevation_deg, azimuth_offset_deg (counter-clockwise), "
      "origin_left_m, origin_up_m and firing_time_us",
      ""};
  return format;
}

std::vector<Laser> readBeamTable(const std::filesystem::path& file) {
  const BeamTableFile table(file);
  const auto own = table.column({"elevation_deg"});
  const auto hesai = table.column({"elevation"});
  if (!own && !hesai) {
    throw InputError(table.head().where, fmt::format("must name the columns, such as Channel,Elevation,Azimuth (Hesai) "
                                                     "or elevation_deg,azimuth_offset_deg, but is: {}",
                                                     quotedForMessage(table.head().text)));
  }
  if (own) {
    table.expectOnly({"channel", "laserid", "laser_id", "ring", "elevation_deg", "azimuth_offset_deg", "origin_left_m",
                      "origin_up_m", "firing_time_us"});
  } else {
    table.expectOnly({"channel", "laserid", "laser_id", "ring", "elevation", "azimuth"});
  }
  const auto azimuth = own ? table.column({"azimuth_offset_deg"}) : table.column({"azimuth"});
  std::vector<Laser> lasers;
  for (const double elevation : table.numbers(own ? *own : *hesai, {-90, 90})) {
    lasers.push_back({elevation, 0, 0, 0, 0});
  }
  const auto fill = [&](const std::optional<std::size_t>& column, double Laser::*figure, double sign, double most) {
    if (!column) return;
    const std::vector<double> numbers = table.numbers(*column, {-most, most});
    for (std::size_t i = 0; i < lasers.size(); ++i) lasers[i].*figure = numbers[i] == 0 ? 0 : sign * numbers[i];
  };
  fill(azimuth, &Laser::azimuth, own ? 1 : -1, 360);
  if (own) {
    fill(table.column({"origin_left_m"}), &Laser::left, 1, 10);
    fill(table.column({"origin_up_m"}), &Laser::up, 1, 10);
    fill(table.column({"firing_time_us"}), &Laser::firing, 1, 1e8);
  }
  for (Laser& laser : lasers) laser.azimuth = std::remainder(laser.azimuth, 360.0);
  return lasers;
}

std::vector<double> readFiringTable(const std::filesystem::path& file) {
  const BeamTableFile table(file);
  const auto micro = table.column({"firing_time_us", "firetimeus"});
  if (table.column({"firetime"})) {
    throw InputError(table.head().where, "the times have no unit: call the column 'fire time(us)' or 'fire time(ns)'");
  }
  const auto nano = table.column({"even_firetimens", "firetimens"});
  if (!micro && !nano) {
    throw InputError(
        table.head().where,
        fmt::format("must name the columns, such as Channel,fire time(us), but is: {}; files with several firing "
                    "states are not read: put the times of one state into a table with the column firing_time_us",
                    quotedForMessage(table.head().text)));
  }
  std::vector<double> times = table.numbers(micro ? *micro : *nano);
  if (const auto odd = table.column({"odd_firetimens"}); odd && table.numbers(*odd) != times) {
    throw InputError(table.head().where,
                     "has two firing states, even and odd, with different times: put the times of one state into a "
                     "table with the column firing_time_us");
  }
  const double first = *std::min_element(times.begin(), times.end());
  for (double& time : times) time = (time - first) * (micro ? 1 : 1e-3);
  return times;
}

}  // namespace scanmill
