#pragma once

// The functions that create the formats of formats(), each defined in the file of its format.

#include <memory>

#include "formats/format.h"

namespace scanmill {

std::unique_ptr<Format> makePcd(Fields& options);
std::unique_ptr<Format> makeDraco(Fields& options);
std::unique_ptr<Format> makeCsv(Fields& options);

}  // namespace scanmill
