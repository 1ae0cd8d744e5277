#pragma once

// Vector instructions beyond those that the build may take for granted.

// SCANMILL_BEST_INSTRUCTIONS stands before a function. The function is then compiled three times, for x86-64-v2, v3
// (AVX2) and v4 (AVX-512), together with all that it calls in its file; when the program starts, it takes the best
// version that the processor can run. It is meant for the loops over beams that take most of the time, which become two
// to three times as fast. All versions give the same bytes, since no operations are contracted and lanes are
// independent.
//
// Functions from other files are not compiled anew. GCC makes no versions of virtual functions: let those call a plain
// function that has them. The macro is empty in a build for the own processor (SCANMILL_NATIVE), which has no use for
// it; with sanitizers, since the choice of versions runs before they are ready; and with clang, which refuses the two
// attributes together.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && !defined(__AVX2__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SCANMILL_BEST_INSTRUCTIONS \
  __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"), flatten))
#else
#define SCANMILL_BEST_INSTRUCTIONS
#endif
