#include "bsp/api/storage.h"

#include <atomic>

#include "bsp/bare/boot.h"
#include "bsp/bare/semihosting.h"

namespace pirvs::bsp {
namespace {

struct Slot {
  std::atomic<bool> used{false};
  bool to_read = false;
  int64_t handle = -1;
} files[kFilesMax];

Slot& slot_of(File file) {
  PIRVS_ASSERT(file.id >= 0 && file.id < kFilesMax && files[file.id].used);
  return files[file.id];
}

int64_t handle_of(File file, bool to_read) {
  const Slot& slot = slot_of(file);
  PIRVS_ASSERT(slot.to_read == to_read);
  return slot.handle;
}

Result<File> open_slot(const char* name, bool to_read) {
  if (!boot_argument("semihosting")) return Status::kNotFound;
  int id = 0;
  while (id < kFilesMax && files[id].used.exchange(true)) ++id;
  if (id == kFilesMax) return Status::kFull;
  Slot& slot = files[id];
  slot.handle = to_read ? semihosting_open_to_read(name) : semihosting_open(name);
  slot.to_read = to_read;
  if (slot.handle >= 0) return File{id};
  slot.used = false;
  return to_read ? Status::kNotFound : Status::kBusFault;
}

}  // namespace

// Files exist only where a debugger or emulator keeps them for us.
Result<File> storage_open(const char* name) { return open_slot(name, false); }

Result<File> storage_open_to_read(const char* name) { return open_slot(name, true); }

Status storage_write(File file, const void* data, size_t size) {
  const int64_t handle = handle_of(file, false);
  return semihosting_write(handle, data, size) ? Status::kOk : Status::kBusFault;
}

Result<size_t> storage_read(File file, void* data, size_t max) {
  return semihosting_read(handle_of(file, true), data, max);
}

Result<uint64_t> storage_size(File file) {
  const int64_t size = semihosting_size(handle_of(file, true));
  if (size < 0) return Status::kBusFault;
  return static_cast<uint64_t>(size);
}

// Nobody promises when the host's file is on its disk.
Status storage_sync(File file) {
  (void)handle_of(file, false);
  return Status::kNotFound;
}

Status storage_close(File file) {
  Slot& slot = slot_of(file);
  const int64_t handle = slot.handle;
  slot.used = false;
  return semihosting_close(handle) ? Status::kOk : Status::kBusFault;
}

Status storage_rename(const char* from, const char* to) {
  if (!boot_argument("semihosting")) return Status::kNotFound;
  return semihosting_rename(from, to) ? Status::kOk : Status::kNotFound;
}

Status storage_remove(const char* name) {
  if (!boot_argument("semihosting")) return Status::kNotFound;
  return semihosting_remove(name) ? Status::kOk : Status::kNotFound;
}

}  // namespace pirvs::bsp
