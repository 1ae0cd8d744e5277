#pragma once

// The unit of coordinates in LAS files, from the records of their coordinate system: OGC's well-known text (WKT 1 or 2)
// or the keys of GeoTIFF.

#include <optional>
#include <string>
#include <string_view>

namespace scanmill {

struct LasUnit {
  double horizontal = 1;           // metres per unit of x and y
  std::optional<double> vertical;  // metres per unit of z; none: as of x and y
  std::string name = "metre";      // of the unit of x and y
  bool degrees = false;            // true: x and y are longitude and latitude
  int unknown = 0;                 // EPSG's code of a unit whose size is not known; 0: none
  int unstated = 0;                // EPSG's code of a system whose unit the file does not state; 0: none
};

// Returns the unit that a well-known text states; metres if it states none that can be read.
LasUnit unitOfWkt(std::string_view text);

// Returns the unit that the keys of GeoTIFF state: a directory of uint16, and float64 numbers to which it refers.
LasUnit unitOfGeoKeys(std::string_view directory, std::string_view numbers);

}  // namespace scanmill
