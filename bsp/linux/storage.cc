#include "bsp/linux/storage.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>

#include "bsp/api/storage.h"

namespace pirvs::bsp {
namespace {

struct Slot {
  std::atomic<bool> used{false};
  bool to_read = false;
  int fd = -1;
};
struct {
  char directory[PATH_MAX] = ".";  // a copy: files never go where a freed text points
  Slot slots[kFilesMax];
} storage;

Status status_of_errno() {
  switch (errno) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
    case EMFILE:
    case ENFILE:
      return Status::kFull;
    case ENOENT:
    case ENOTDIR:
      return Status::kNotFound;
    default:
      return Status::kBusFault;
  }
}

// The folders of a path, from the first slash behind the storage's own directory on.
void make_folders(char* path, size_t from) {
  for (size_t i = from; path[i] != '\0'; ++i) {
    if (path[i] != '/') continue;
    path[i] = '\0';
    (void)mkdir(path, 0755);  // open() tells when this was in vain
    path[i] = '/';
  }
}

Slot& slot_of(File file) {
  PIRVS_ASSERT(file.id >= 0 && file.id < kFilesMax && storage.slots[file.id].used);
  return storage.slots[file.id];
}

int fd_of(File file, bool to_read) {
  const Slot& slot = slot_of(file);
  PIRVS_ASSERT(slot.to_read == to_read);
  return slot.fd;
}

struct Path {
  char text[PATH_MAX];

  bool set(const char* name) {
    const int length = snprintf(text, sizeof text, "%s/%s", storage.directory, name);
    return length >= 0 && length < PATH_MAX;
  }
};

// -1: errno says why.
int open_path(const char* name, bool to_read) {
  Path path;
  if (!path.set(name)) {
    errno = ENOENT;
    return -1;
  }
  const int flags = O_CLOEXEC | (to_read ? O_RDONLY : O_WRONLY | O_CREAT | O_TRUNC);
  const int fd = open(path.text, flags, 0644);
  if (fd >= 0 || errno != ENOENT || to_read) return fd;
  make_folders(path.text, strlen(storage.directory) + 1);
  return open(path.text, flags, 0644);
}

Result<File> open_slot(const char* name, bool to_read) {
  int id = 0;
  while (id < kFilesMax && storage.slots[id].used.exchange(true)) ++id;
  if (id == kFilesMax) return Status::kFull;
  Slot& slot = storage.slots[id];
  slot.fd = open_path(name, to_read);
  slot.to_read = to_read;
  if (slot.fd >= 0) return File{id};
  const Status status = status_of_errno();
  slot.used = false;
  return status;
}

// A name is on the medium when the folder is that holds it.
Status sync_folder_of(Path path) {
  *strrchr(path.text, '/') = '\0';
  const int fd = open(path.text, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return status_of_errno();
  const Status status = fsync(fd) == 0 ? Status::kOk : status_of_errno();
  close(fd);
  return status;
}

}  // namespace

void set_storage_directory(const char* directory) {
  const size_t length = strlen(directory);
  PIRVS_ASSERT(length < sizeof storage.directory);
  memmove(storage.directory, directory, length + 1);
}

Result<File> storage_open(const char* name) { return open_slot(name, false); }

Result<File> storage_open_to_read(const char* name) { return open_slot(name, true); }

Status storage_write(File file, const void* data, size_t size) {
  const int fd = fd_of(file, false);
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(fd, next, size);
    if (written < 0) {
      if (errno == EINTR) continue;
      return status_of_errno();
    }
    next += written;
    size -= static_cast<size_t>(written);
  }
  return Status::kOk;
}

Result<size_t> storage_read(File file, void* data, size_t max) {
  const int fd = fd_of(file, true);
  char* const to = static_cast<char*>(data);
  size_t size = 0;
  while (size < max) {
    const ssize_t got = read(fd, to + size, max - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return status_of_errno();
    if (got == 0) break;
    size += static_cast<size_t>(got);
  }
  return size;
}

Result<uint64_t> storage_size(File file) {
  struct stat about;
  if (fstat(fd_of(file, true), &about) != 0) return status_of_errno();
  return static_cast<uint64_t>(about.st_size);
}

Status storage_sync(File file) {
  return fsync(fd_of(file, false)) == 0 ? Status::kOk : status_of_errno();
}

Status storage_close(File file) {
  Slot& slot = slot_of(file);
  const int fd = slot.fd;
  slot.used = false;
  return close(fd) == 0 ? Status::kOk : status_of_errno();
}

Status storage_rename(const char* from, const char* to) {
  Path old_path, new_path;
  if (!old_path.set(from) || !new_path.set(to)) return Status::kNotFound;
  if (rename(old_path.text, new_path.text) != 0) return status_of_errno();
  return sync_folder_of(new_path);
}

Status storage_remove(const char* name) {
  Path path;
  if (!path.set(name)) return Status::kNotFound;
  return unlink(path.text) == 0 ? Status::kOk : status_of_errno();
}

}  // namespace pirvs::bsp
