#pragma once

// Vector instructions beyond those that the build may take for granted.

// Before a function: it is compiled for x86-64-v2, v3 (AVX2) and v4 (AVX-512), with all that it calls, and the program
// takes the best version that the processor has when it starts. For the loops over beams in which the time goes: they
// are twice to three times as fast. All versions give the same bytes, since nothing is contracted and lanes are
// independent. Functions that it calls from other files stay as they are. A build for the own processor
// (SCANMILL_NATIVE) has no use for it; sanitizers do not bear code that runs before them, and clang refuses the pair of
// attributes. GCC knows no versions of virtual functions: let those call one.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && !defined(__AVX2__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SCANMILL_BEST_INSTRUCTIONS \
  __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"), flatten))
#else
#define SCANMILL_BEST_INSTRUCTIONS
#endif
