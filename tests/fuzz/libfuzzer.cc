// libFuzzer's entry: PIRVS_FUZZ names the target. Built by `make fuzz` alone.
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/targets.h"

namespace {
const pirvs::fuzz::Target* target = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* const name = std::getenv("PIRVS_FUZZ");
  target = pirvs::fuzz::find_target(name ? name : "");
  if (target != nullptr) return 0;
  std::fprintf(stderr, "no such fuzz target: %s; there are:", name ? name : "");
  for (size_t i = 0; i < pirvs::fuzz::kTargetCount; ++i) {
    std::fprintf(stderr, " %s", pirvs::fuzz::kTargets[i].name);
  }
  std::fprintf(stderr, "\n");
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  target->run(data, size);
  return 0;
}
