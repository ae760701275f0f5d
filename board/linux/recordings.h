// Where recordings go, and that they are on the disk: however they are started, bsp/linux/disk_sync
// flushes them from then on.
// In      start(): before the stack runs, since a thread takes heap. answer(): each of the stack's.
// Out     The folder of settings, which is made if it is missing, is that of bsp/api/storage.h;
//         with `record` everything is recorded from the start on. next(): each recording has a new
//         folder in there, whatever starts it (bsp/linux/numbered_folder.h).
// Errors  start: nullptr, or why not. next: as numbered_folder.h.
// Source  docs/device.md, "Recordings".
#pragma once

#include "board/linux/settings.h"
#include "bsp/linux/disk_sync.h"
#include "core/base/text.h"
#include "modules/app/app.h"

namespace pirvs::board {

class Recordings {
 public:
  const char* start(const Settings& settings, App& app);
  Result<const char*> next();  // for AppSinks::new_recording
  void answer(const Answer& answer);
  void stop() { disk_sync_.stop(); }

  uint32_t flushes() const { return disk_sync_.flushes(); }

 private:
  bsp::DiskSync disk_sync_;
  const char* folder_ = ".";
  Text<16> name_;
};

}  // namespace pirvs::board
