// Named files, at most kFilesMax open at a time; no heap.
// In      A name relative to where the backend keeps files, '/' between folders; bytes. Any
//         core; each file from one core at a time.
// Out     storage_open: a file to write, emptied if the name exists; folders of the name that are
//         missing are made, where the backend has folders. storage_open_to_read: from its begin.
//         storage_read: the number of bytes read, fewer than `max` only at the end; 0: the end.
//         storage_sync: what was written is on the medium, and survives loss of power.
//         storage_rename: `to` is the file that was `from`; whoever opens `to`, at any time and
//         after loss of power, finds the old content or the new one, whole.
//         So a file is replaced in one step: write NAME.new, sync, close, rename it to NAME.
// Errors  kNotFound: no such file or directory, or the backend cannot do that at all.
//         open: kFull (too many open). write, sync, close: kFull (disk full or over quota).
//         All: kBusFault (I/O error). After an error of write the tail of the file is unspecified;
//         the file stays open until closed. A file that is not open is a bug and asserts, and so
//         does storage_write of one opened to read, and the reverse.
// Cost    Unbuffered: one system call per read or write, so move whole blocks. storage_sync and
//         storage_rename: until the medium has it, 1 to 100 ms; never from a timed step.
// Source  STYLE principles 3 and 7; POSIX rename().
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/status.h"

namespace pirvs::bsp {

inline constexpr int kFilesMax = 16;

struct File {
  int id = -1;
};

Result<File> storage_open(const char* name);
Result<File> storage_open_to_read(const char* name);
Status storage_write(File file, const void* data, size_t size);
Result<size_t> storage_read(File file, void* data, size_t max);
Result<uint64_t> storage_size(File file);  // of one opened to read
Status storage_sync(File file);
Status storage_close(File file);
Status storage_rename(const char* from, const char* to);
Status storage_remove(const char* name);

}  // namespace pirvs::bsp
