// What libFuzzer calls: FUZZ_TARGET names the target (scripts/fuzz).

#include <cstdio>
#include <cstdlib>

#include "base/error.h"
#include "tests/fuzz/target.h"

namespace {

const scanmill::FuzzTarget& chosen() {
  static const scanmill::FuzzTarget& target = []() -> const scanmill::FuzzTarget& {
    const char* const name = std::getenv("FUZZ_TARGET");
    const auto found = scanmill::fuzzTargets().find(name == nullptr ? "" : name);
    if (found != scanmill::fuzzTargets().end()) return found->second;
    std::fputs("FUZZ_TARGET must be one of:", stderr);
    for (const auto& known : scanmill::fuzzTargets()) std::fprintf(stderr, " %s", known.first.c_str());
    std::fputs("\n", stderr);
    std::exit(2);
  }();
  return target;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    scanmill::runWithinBudget(chosen(), {reinterpret_cast<const char*>(data), size});
  } catch (const scanmill::Error&) {  // it says what is wrong
  }
  return 0;
}
