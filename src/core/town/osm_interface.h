#pragma once

// The module that reads OpenStreetMap files with libosmium.

#include <string>

#include "base/module.h"
#include "town/osm.h"

namespace scanmill::town {

class OsmModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_town.so", "OpenStreetMap files cannot be read",
                                    "install bzip2's, expat's and lz4's libraries (on Debian the packages libbz2-1.0, "
                                    "libexpat1 and liblz4-1)"};

  virtual ~OsmModule() = default;
  // Reads a file, which has nodes, ways and relations in this order, each by their ids. Throws std::exception with what
  // is wrong.
  virtual OsmExtract read(const std::string& file) const = 0;
};

}  // namespace scanmill::town
