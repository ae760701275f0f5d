#include "bsp/linux/storage.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bsp/api/storage.h"

namespace pirvs::bsp {
namespace {

struct {
  const char* directory = ".";
  int fd_plus_1[kFilesMax] = {};  // 0: free
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

int& slot_of(File file) {
  PIRVS_ASSERT(file.id >= 0 && file.id < kFilesMax && storage.fd_plus_1[file.id] != 0);
  return storage.fd_plus_1[file.id];
}

}  // namespace

void set_storage_directory(const char* directory) { storage.directory = directory; }

Result<File> storage_open(const char* name) {
  int id = 0;
  while (id < kFilesMax && storage.fd_plus_1[id] != 0) ++id;
  if (id == kFilesMax) return Status::kFull;
  char path[PATH_MAX];
  const int length = snprintf(path, sizeof path, "%s/%s", storage.directory, name);
  if (length < 0 || length >= PATH_MAX) return Status::kNotFound;
  constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
  int fd = open(path, kFlags, 0644);
  if (fd < 0 && errno == ENOENT) {
    make_folders(path, strlen(storage.directory) + 1);
    fd = open(path, kFlags, 0644);
  }
  if (fd < 0) return status_of_errno();
  storage.fd_plus_1[id] = fd + 1;
  return File{id};
}

Status storage_write(File file, const void* data, size_t size) {
  const int fd = slot_of(file) - 1;
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

Status storage_close(File file) {
  int& slot = slot_of(file);
  const int fd = slot - 1;
  slot = 0;
  return close(fd) == 0 ? Status::kOk : status_of_errno();
}

}  // namespace pirvs::bsp
