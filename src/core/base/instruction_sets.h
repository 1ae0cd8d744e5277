#pragma once

// Lets functions use vector instructions that only some processors have.

// A function marked SCANMILL_BEST_INSTRUCTIONS is compiled three times, for x86-64-v2, v3 (AVX2) and v4 (AVX-512),
// together with all functions of its file that it calls. When the program starts, it chooses the best version that the
// processor can run. The macro is meant for the loops over beams that take most of the time; they become two to three
// times as fast. All versions give the same bytes, since no operations are contracted and lanes are independent.
//
// Functions of other files are not compiled anew. GCC makes no versions of virtual functions: let a virtual function
// call a plain function that has the macro. The macro is empty for processors other than x86-64 and systems other than
// Linux, and in three builds: for the host's own processor (SCANMILL_NATIVE), where it has no use; with sanitizers,
// since the version is chosen before they are ready; and with clang, which refuses target_clones beside flatten.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && !defined(__AVX2__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SCANMILL_BEST_INSTRUCTIONS \
  __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"), flatten))
#else
#define SCANMILL_BEST_INSTRUCTIONS
#endif
