// Flushes written data to the disk once a second, from a thread of its own: a power cut loses no
// more than the last second. No writer waits for it.
// In      start(): a folder on the file system; it must stay valid.
// Errors  start: kNotFound: no such folder; kBusFault: no thread.
// Cost    syncfs() once a second: as long as the disk takes for what is new.
// Source  syncfs(2); ext4 puts data to the disk 30 s late by itself.
#pragma once

#include <pthread.h>

#include <atomic>

#include "core/base/status.h"

namespace pirvs::bsp {

class DiskSync {
 public:
  ~DiskSync() { stop(); }
  Status start(const char* folder);
  void stop();  // with a last one

 private:
  void run();

  int fd_ = -1;
  pthread_t thread_{};
  std::atomic<bool> stop_{false};
};

}  // namespace pirvs::bsp
