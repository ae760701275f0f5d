#include "bsp/api/storage.h"

#include "bsp/bare/boot.h"
#include "bsp/bare/semihosting.h"

namespace pirvs::bsp {
namespace {

struct {
  bool used = false;
  int64_t handle = -1;
} files[kFilesMax];

int64_t& handle_of(File file) {
  PIRVS_ASSERT(file.id >= 0 && file.id < kFilesMax && files[file.id].used);
  return files[file.id].handle;
}

}  // namespace

// Files exist only where a debugger or emulator keeps them for us.
Result<File> storage_open(const char* name) {
  if (!boot_argument("semihosting")) return Status::kNotFound;
  int id = 0;
  while (id < kFilesMax && files[id].used) ++id;
  if (id == kFilesMax) return Status::kFull;
  const int64_t handle = semihosting_open(name);
  if (handle < 0) return Status::kBusFault;
  files[id] = {true, handle};
  return File{id};
}

Status storage_write(File file, const void* data, size_t size) {
  return semihosting_write(handle_of(file), data, size) ? Status::kOk : Status::kBusFault;
}

Status storage_close(File file) {
  const int64_t handle = handle_of(file);
  files[file.id].used = false;
  return semihosting_close(handle) ? Status::kOk : Status::kBusFault;
}

}  // namespace pirvs::bsp
