// Named output files, at most kFilesMax open at a time; no heap.
// In      A name relative to where the backend puts files, '/' between folders; bytes.
// Out     A File to write to and close. Opening an existing name empties it; folders of the name
//         that are missing are made, where the backend has folders.
// Errors  open: kFull (too many open), kNotFound (no such directory), kBusFault.
//         write, close: kFull (disk full or over quota), kBusFault (I/O error). After an error the
//         tail of the file is unspecified; the file stays open until closed.
// Cost    Unbuffered: one system call per write, so write whole blocks.
// Source  STYLE principles 3 and 7.
#pragma once

#include <cstddef>

#include "core/base/status.h"

namespace pirvs::bsp {

inline constexpr int kFilesMax = 16;

struct File {
  int id = -1;
};

Result<File> storage_open(const char* name);
Status storage_write(File file, const void* data, size_t size);
Status storage_close(File file);

}  // namespace pirvs::bsp
