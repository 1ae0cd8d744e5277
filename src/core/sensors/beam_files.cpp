#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <string_view>

#include "base/format_support.h"
#include "sensors/calibration.h"
#include "sensors/text_table.h"

namespace scanmill {
namespace {

// Returns the rows of a table in the order of its channels, or as they are if it has none. Channels are numbered from
// 1, or from 0 if the table has a channel 0.
std::vector<std::size_t> rowsByChannel(const TextTable& table) {
  std::vector<std::size_t> rows(table.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  const auto name = std::find_if(table.names().begin(), table.names().end(), [](const std::string& n) {
    return n == "channel" || n == "laserid" || n == "laser_id" || n == "ring";
  });
  if (name == table.names().end()) return rows;
  std::vector<double> channels;
  for (std::size_t row = 0; row < table.size(); ++row) channels.push_back(table.number(row, *name));
  const double least = std::find(channels.begin(), channels.end(), 0) == channels.end() ? 1 : 0;
  std::vector<bool> known(table.size());
  for (std::size_t row = 0; row < table.size(); ++row) {
    const double at = channels[row] - least;
    if (at != std::floor(at) || at < 0 || at >= static_cast<double>(table.size())) {
      throw InputError(table.where(row),
                       fmt::format("has the channel {:g}, but a table of {} lines has the channels {:g} to {:g}",
                                   channels[row], table.size(), least, least + static_cast<double>(table.size()) - 1));
    }
    const auto place = static_cast<std::size_t>(at);
    if (known[place]) {
      throw InputError(table.where(row), "has the channel of an earlier line: give each channel one line");
    }
    known[place] = true;
    rows[place] = row;
  }
  return rows;
}

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
  const TextTable table(file);
  const bool own = table.has("elevation_deg");
  if (!own && !table.has("elevation")) {
    throw InputError(table.head(),
                     "must name the columns, such as Channel,Elevation,Azimuth (Hesai) or "
                     "elevation_deg,azimuth_offset_deg");
  }
  std::vector<std::string> known{"channel", "laserid", "laser_id", "ring"};
  if (own) {
    known.insert(known.end(),
                 {"elevation_deg", "azimuth_offset_deg", "origin_left_m", "origin_up_m", "firing_time_us"});
  } else {
    known.insert(known.end(), {"elevation", "azimuth"});
  }
  table.expectOnly(known);
  std::vector<Laser> lasers;
  for (const std::size_t row : rowsByChannel(table)) {
    const auto figure = [&](const char* name, double most) { return table.number(row, name, {-most, most}); };
    if (own) {
      lasers.push_back({figure("elevation_deg", 90), std::remainder(figure("azimuth_offset_deg", 360), 360.0),
                        figure("origin_left_m", 10), figure("origin_up_m", 10), figure("firing_time_us", 1e8)});
    } else {
      lasers.push_back({figure("elevation", 90), std::remainder(0 - figure("azimuth", 360), 360.0), 0, 0, 0});
    }
  }
  return lasers;
}

std::vector<double> readFiringTable(const std::filesystem::path& file) {
  const TextTable table(file);
  const char* name = "";
  for (const char* known : {"firing_time_us", "firetime_us", "even_firetime_ns", "firetime_ns"}) {
    if (*name == '\0' && table.has(known)) name = known;
  }
  if (*name == '\0') {
    throw InputError(table.head(),
                     "must name the columns, such as Channel,fire time(us) or fire time(ns); files with several firing "
                     "states are not read: put the times of one state into a table with the column firing_time_us");
  }
  std::vector<double> times;
  for (const std::size_t row : rowsByChannel(table)) {
    times.push_back(table.number(row, name));
    if (table.has("odd_firetime_ns") && table.number(row, "odd_firetime_ns") != times.back()) {
      throw InputError(table.head(),
                       "has two firing states, even and odd, with different times: put the times of one state into a "
                       "table with the column firing_time_us");
    }
  }
  const double first = *std::min_element(times.begin(), times.end());
  for (double& time : times) time = (time - first) * (std::string_view(name).ends_with("us") ? 1 : 1e-3);
  return times;
}

}  // namespace scanmill
