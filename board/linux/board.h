// What a board under Linux adds to the device program: who runs where. Defined in
// board/<name>/board.cc; board/linux/main.cc runs the application on it.
// Errors  none; what the machine does not permit or have is said in one line, and the program runs.
// Source  docs/adr/0010-a-live-board-under-linux.md.
#pragma once

#include "bsp/linux/cores.h"
#include "bsp/linux/media_graph.h"
#include "bsp/linux/pixel_format.h"
#include "modules/app/app.h"

namespace pirvs::board {

struct LinuxBoard {
  const char* name;
  CorePlan plan;
  bsp::CoreSetup cores[bsp::kCoresMax];    // those of the plan, then the recorder's
  const bsp::MediaTable* media = nullptr;  // camera.left = isp:0; nullptr: there are no ISPs
  bsp::JpegToGrey jpeg = nullptr;
};
extern const LinuxBoard kBoard;

}  // namespace pirvs::board
