#pragma once

// What the table of formats holds; each is defined in the format's own file.

#include <memory>

#include "formats/format.h"

namespace scanmill {

std::unique_ptr<Format> makePcd(Fields& options);
std::unique_ptr<Format> makeDraco(Fields& options);
std::unique_ptr<Format> makeCsv(Fields& options);

}  // namespace scanmill
