#pragma once

// Whether the program is built with a sanitizer: slower by far, and freed memory is kept for a while.

namespace scanmill {

#ifdef SCANMILL_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace scanmill
