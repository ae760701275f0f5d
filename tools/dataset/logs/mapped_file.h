// What    A file's bytes, read only, as the kernel brings them in; and chunks of it unpacked.
// In      A path; a compression by the name that logs give it: "", none, lz4 (frames), bz2, zstd.
// Errors  InputError: cannot be opened, not what the compression says.
// Cost    no copy; unpacking some 500 MB/s (lz4).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/dataset/logs/log_file.h"

namespace pirvs::tools {

class MappedFile {
 public:
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  Bytes bytes() const { return bytes_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  Bytes bytes_;
};

// `size`: what it says that it holds.
void unpack(const std::string& compression, Bytes packed, uint64_t size, const std::string& path,
            std::vector<uint8_t>& out);

// A little-endian number; the caller has seen that the bytes are there.
template <class T>
T little(const uint8_t* from) {
  T value = 0;
  for (size_t i = 0; i < sizeof(T); ++i) value = T(value | T(T(from[i]) << (8 * i)));
  return value;
}

}  // namespace pirvs::tools
