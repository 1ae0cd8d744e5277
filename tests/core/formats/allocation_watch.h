#pragma once

#include <cstddef>

namespace scanmill {

// The largest request for memory through operator new, the libraries' included, since the last call.
std::size_t largestRequestSinceLastCall();

}  // namespace scanmill
