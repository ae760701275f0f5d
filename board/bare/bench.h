// Single kernels on two images of the recording, each in a trace scope "bench.NAME" of its own.
// In      Two moments of one camera, at least 200 x 120 px.
// Out     done() per kernel: what it took by bsp::read_cycles. The goal stands in the kernel's
//         header, "Goal    A72 cycles: NAME 4.0 a UNIT"; tools/prof/profile compares.
// Errors  none.
// Cost    About 0.1 s on an A72.
// Source  the workloads of core/kernels/*/*_bench.cc.
#pragma once

#include "bsp/api/cycles.h"
#include "core/kernels/image.h"

namespace pirvs::board {

struct BenchResult {
  const char* name;  // "bench.NAME"
  const char* unit;
  uint64_t units;
  bsp::Cycles spent;
};

void bench_kernels(const ImageView& before, const ImageView& after,
                   void (*done)(const BenchResult& result));

}  // namespace pirvs::board
