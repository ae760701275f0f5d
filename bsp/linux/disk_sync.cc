#include "bsp/linux/disk_sync.h"

#include <fcntl.h>
#include <time.h>
#include <unistd.h>

#include "bsp/api/clock.h"

namespace pirvs::bsp {

Status DiskSync::start(const char* folder, TimeNs period_ns) {
  stop();
  folder_ = folder;
  period_ns_ = period_ns;
  begun_ = stop_ = false;
  (void)sem_init(&told_, 0, 0);
  const auto entry = [](void* self) -> void* {
    static_cast<DiskSync*>(self)->run();
    return nullptr;
  };
  runs_ = pthread_create(&thread_, nullptr, entry, this) == 0;
  return runs_ ? Status::kOk : Status::kBusFault;
}

void DiskSync::begin() {
  if (runs_ && !begun_.exchange(true)) (void)sem_post(&told_);
}

void DiskSync::stop() {
  if (!runs_) return;
  stop_ = true;
  (void)sem_post(&told_);
  pthread_join(thread_, nullptr);
  (void)sem_destroy(&told_);
  runs_ = false;
}

// Not opened before: the file system may be mounted late.
void DiskSync::run() {
  constexpr TimeNs kSecond_ns = 1'000'000'000;
  while (!begun_ && !stop_) (void)sem_wait(&told_);
  const int fd = begun_ ? open(folder_, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
  if (fd < 0) return;
  while (!stop_) {
    const TimeNs t = now() + period_ns_;
    const timespec until = {static_cast<time_t>(t / kSecond_ns), static_cast<long>(t % kSecond_ns)};
    (void)sem_clockwait(&told_, CLOCK_MONOTONIC, &until);  // stop() ends it early
    (void)syncfs(fd);
    ++flushes_;
  }
  close(fd);
}

}  // namespace pirvs::bsp
