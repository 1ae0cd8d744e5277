#pragma once

// The unit of coordinates in LAS files and GeoTIFF, from the coordinate system that they state: OGC's well-known text
// (WKT 1 or 2) or the keys of GeoTIFF.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace scanmill {

struct SystemUnit {
  double horizontal = 1;           // metres per unit of x and y
  std::optional<double> vertical;  // metres per unit of z, negative if z points down; none: as of x and y
  std::string name = {};           // of the unit of x and y; empty: no unit is stated, and horizontal is 1
  bool degrees = false;            // true: x and y are longitude and latitude
  bool geocentric = false;         // true: the origin is the earth's centre
  bool mercator = false;           // true: a Mercator projection with the equator along x, such as Web Mercator
  bool mirrored = false;           // true: the axes are south and west or the like, so that the ground is mirrored
  bool unread = false;             // true: a system is stated in a way that is not known
  int code = 0;                    // EPSG's code of a projected system that keys state; 0: none
  int unknown = 0;                 // EPSG's code of a unit whose size is not known; 0: none
  int unstated = 0;                // EPSG's code of a system whose unit the file does not state; 0: none
};

// Returns the unit that a well-known text states; metres if it states none, or if it cannot be read.
SystemUnit unitOfWkt(std::string_view text);

// Returns the unit that the keys of GeoTIFF state: a directory of uint16, and float64 numbers and texts to which it
// refers. The citation of the vertical system, such as "NAVD88 height (ftUS)", counts if nothing else states its unit.
SystemUnit unitOfGeoKeys(std::string_view directory, std::string_view numbers, std::string_view texts);

// Returns the unit that the keys of a GeoTIFF state; metres if the file has none or is no TIFF. `vertical` is left open
// if the file states the unit of its values besides.
SystemUnit unitOfTiff(const std::filesystem::path& file);

}  // namespace scanmill
