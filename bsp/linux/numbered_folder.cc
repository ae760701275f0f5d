#include "bsp/linux/numbered_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

namespace pirvs::bsp {
namespace {

constexpr uint32_t kNumberMax = 999'999'998;
constexpr int kDigits = 4;

// 0: not one of ours.
uint32_t number_of(const char* name) {
  uint32_t number = 0;
  for (const char* c = name; *c != 0; ++c) {
    if (*c < '0' || *c > '9' || number > kNumberMax / 10) return 0;
    number = 10 * number + static_cast<uint32_t>(*c - '0');
  }
  return number;
}

// Not by readdir(), which takes heap.
uint32_t highest_number(int folder) {
  uint32_t highest = 0;
  alignas(dirent64) char entries[4096];
  for (;;) {
    const ssize_t size = getdents64(folder, entries, sizeof entries);
    if (size <= 0) return highest;
    for (ssize_t at = 0; at < size;) {
      const auto* const entry = reinterpret_cast<const dirent64*>(entries + at);
      highest = std::max(highest, number_of(entry->d_name));
      at += entry->d_reclen;
    }
  }
}

void put_name(uint32_t number, TextWriter& name) {
  name.clear();
  uint32_t digits = 1;
  for (uint32_t rest = number; rest >= 10; rest /= 10) ++digits;
  for (; digits < kDigits; ++digits) name.put('0');
  name.unsigned_number(number);
}

Status status_of_errno() {
  if (errno == ENOSPC || errno == EDQUOT) return Status::kFull;
  return errno == ENOENT || errno == ENOTDIR ? Status::kNotFound : Status::kBusFault;
}

}  // namespace

Status make_numbered_folder(const char* in, TextWriter& name) {
  const int folder = open(in, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return status_of_errno();
  uint32_t number = highest_number(folder);
  int made = -1;
  do {  // again: another one made it in between
    put_name(++number, name);
    made = mkdirat(folder, name.c_str(), 0755);
  } while (made != 0 && errno == EEXIST);
  const Status status = made == 0 ? Status::kOk : status_of_errno();
  close(folder);
  return status;
}

}  // namespace pirvs::bsp
