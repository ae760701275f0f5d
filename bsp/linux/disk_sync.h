// Flushes written data to the disk once a second, from a thread of its own: a power cut loses no
// more than the last second. No writer waits for it.
// In      start(): a folder of the file system; the text must outlive this. begin(): the folder is
//         there, and from now on there is something to flush; from any thread, without heap.
// Errors  start: kBusFault: no thread. A folder that cannot be opened is not flushed: flushes().
// Cost    Nothing before begin(); then syncfs() once a period: as long as the disk takes for what
//         is new.
// Source  syncfs(2); ext4 puts data to the disk 30 s late by itself.
#pragma once

#include <pthread.h>
#include <semaphore.h>

#include <atomic>

#include "core/base/counter.h"
#include "core/base/status.h"
#include "core/base/time.h"

namespace pirvs::bsp {

class DiskSync {
 public:
  ~DiskSync() { stop(); }
  Status start(const char* folder, TimeNs period_ns = 1'000'000'000);
  void begin();
  void stop();  // with a last one

  uint32_t flushes() const { return flushes_; }

 private:
  void run();

  const char* folder_ = "";
  bool runs_ = false;
  TimeNs period_ns_ = 0;
  pthread_t thread_{};
  sem_t told_{};
  std::atomic<bool> begun_{false}, stop_{false};
  Counter flushes_;
};

}  // namespace pirvs::bsp
