# What every library is compiled and linked with: scanmill_options.

add_library(scanmill_options INTERFACE)
target_include_directories(scanmill_options INTERFACE ${PROJECT_SOURCE_DIR}/src/core ${PROJECT_BINARY_DIR}/generated)
target_compile_definitions(scanmill_options INTERFACE SCANMILL_EMBREE_MAJOR=${embree_VERSION_MAJOR})
target_compile_options(scanmill_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                                  -Wnon-virtual-dtor $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> -ffp-contract=off -fno-math-errno
                                                  -fno-trapping-math)
# Contraction is off and lanes are independent: the same bytes come from any instruction set. Nobody reads errno or
# floating-point exceptions; without these promises g++ keeps loops with a square root or a selection scalar.
if(SCANMILL_NATIVE)
  target_compile_options(scanmill_options INTERFACE -march=native)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  target_compile_options(scanmill_options INTERFACE -march=x86-64-v2)
endif()
if(SCANMILL_WERROR)
  target_compile_options(scanmill_options INTERFACE -Werror)
endif()
if(SCANMILL_SANITIZE)
  # With its checks in between, g++ 12 takes members of std::regex for uninitialised.
  target_compile_options(scanmill_options INTERFACE -fsanitize=${SCANMILL_SANITIZE} -fno-omit-frame-pointer
                                                    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(scanmill_options INTERFACE -fsanitize=${SCANMILL_SANITIZE})
endif()
target_link_options(scanmill_options INTERFACE -Wl,--as-needed)
target_link_libraries(scanmill_options INTERFACE Threads::Threads fmt::fmt)
