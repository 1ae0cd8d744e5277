#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <string_view>

#include "base/format_support.h"
#include "sensors/calibration.h"
#include "sensors/text_table.h"

namespace scanmill {
namespace {

constexpr std::array<std::string_view, 4> kChannelNames{"channel", "laserid", "laser_id", "ring"};

// Returns the indices of a table's rows, sorted by channel, or in the file's order if the table has no channels.
// Channels are numbered without gaps from 1, or from 0 if the table has a channel 0; otherwise InputError is thrown.
std::vector<std::size_t> rowsByChannel(const TextTable& table) {
  std::vector<std::size_t> rows(table.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  const auto name = std::ranges::find_first_of(table.names(), kChannelNames);
  if (name == table.names().end()) return rows;
  std::vector<double> channels;
  for (std::size_t row = 0; row < table.size(); ++row) channels.push_back(table.number(row, *name));
  const double firstChannel = std::ranges::find(channels, 0) == channels.end() ? 1 : 0;
  const double lastChannel = firstChannel + static_cast<double>(table.size()) - 1;
  std::vector<bool> isTaken(table.size());  // by channel, from the first one
  for (std::size_t row = 0; row < table.size(); ++row) {
    const double channel = channels[row];
    if (channel != std::floor(channel) || channel < firstChannel || channel > lastChannel) {
      throw InputError(table.where(row),
                       fmt::format("has the channel {:g}, but a table of {} lines has the channels {:g} to {:g}",
                                   channel, table.size(), firstChannel, lastChannel));
    }
    const auto index = static_cast<std::size_t>(channel - firstChannel);
    if (isTaken[index]) {
      throw InputError(table.where(row), "has the channel of an earlier line: give each channel one line");
    }
    isTaken[index] = true;
    rows[index] = row;
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
  // A table of Hesai's, whose azimuths are clockwise, has the column elevation instead of elevation_deg.
  const bool hesai = !table.has("elevation_deg");
  if (hesai && !table.has("elevation")) {
    throw InputError(table.head(),
                     "must name the columns, such as Channel,Elevation,Azimuth (Hesai) or "
                     "elevation_deg,azimuth_offset_deg");
  }
  std::vector<std::string> columns(kChannelNames.begin(), kChannelNames.end());
  if (hesai) {
    columns.insert(columns.end(), {"elevation", "azimuth"});
  } else {
    columns.insert(columns.end(),
                   {"elevation_deg", "azimuth_offset_deg", "origin_left_m", "origin_up_m", "firing_time_us"});
  }
  table.expectOnly(columns);
  std::vector<Laser> lasers;
  for (const std::size_t row : rowsByChannel(table)) {
    // Returns 0 for a column that the table lacks.
    const auto number = [&](const char* name, double limit) { return table.number(row, name, {-limit, limit}); };
    const double azimuth = hesai ? 0 - number("azimuth", 360) : number("azimuth_offset_deg", 360);
    lasers.push_back({.elevation = number(hesai ? "elevation" : "elevation_deg", 90),
                      .azimuth = std::remainder(azimuth, 360.0),
                      .left = number("origin_left_m", 10),
                      .up = number("origin_up_m", 10),
                      .firing = number("firing_time_us", 1e8)});
  }
  return lasers;
}

std::vector<double> readFiringTable(const std::filesystem::path& file) {
  const TextTable table(file);
  constexpr std::array<std::string_view, 4> kTimeNames{"firing_time_us", "firetime_us", "even_firetime_ns",
                                                       "firetime_ns"};
  const auto* const name = std::ranges::find_if(kTimeNames, [&](std::string_view n) { return table.has(n); });
  if (name == kTimeNames.end()) {
    throw InputError(table.head(),
                     "must name the columns, such as Channel,fire time(us) or fire time(ns); files with several firing "
                     "states are not read: put the times of one state into a table with the column firing_time_us");
  }
  std::vector<double> times;
  for (const std::size_t row : rowsByChannel(table)) {
    times.push_back(table.number(row, *name));
    if (table.has("odd_firetime_ns") && table.number(row, "odd_firetime_ns") != times.back()) {
      throw InputError(table.head(),
                       "has two firing states, even and odd, with different times: put the times of one state into a "
                       "table with the column firing_time_us");
    }
  }
  const double earliest = std::ranges::min(times);
  for (double& time : times) time = (time - earliest) * (name->ends_with("us") ? 1 : 1e-3);
  return times;
}

}  // namespace scanmill
