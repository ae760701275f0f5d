#include "bsp/linux/disk_sync.h"

#include <fcntl.h>
#include <time.h>
#include <unistd.h>

namespace pirvs::bsp {

Status DiskSync::start(const char* folder) {
  stop();
  fd_ = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd_ < 0) return Status::kNotFound;
  stop_ = false;
  const auto entry = [](void* self) -> void* {
    static_cast<DiskSync*>(self)->run();
    return nullptr;
  };
  if (pthread_create(&thread_, nullptr, entry, this) == 0) return Status::kOk;
  close(fd_);
  fd_ = -1;
  return Status::kBusFault;
}

void DiskSync::stop() {
  if (fd_ < 0) return;
  stop_ = true;
  pthread_join(thread_, nullptr);
  (void)syncfs(fd_);
  close(fd_);
  fd_ = -1;
}

void DiskSync::run() {
  constexpr int kLooks = 10;  // a second, for stop()
  const timespec rest{0, 1'000'000'000 / kLooks};
  for (int look = 1; !stop_; ++look) {
    nanosleep(&rest, nullptr);
    if (look % kLooks == 0) (void)syncfs(fd_);
  }
}

}  // namespace pirvs::bsp
