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

// A log whose messages lie in chunks of the file, which may be packed; load() keeps one at hand.
class ChunkedLog : public LogFile {
 public:
  explicit ChunkedLog(const std::string& path) : file_(path) {}
  Bytes load(const LogPlace& place) override;

 protected:
  // Brings the content of the packed chunk at that place into chunk_; nothing if there is none.
  virtual void open_chunk(uint64_t at) = 0;
  Bytes chunk() const { return {chunk_.data(), chunk_.size()}; }
  // Where the bytes of a message are, `packed` as open_chunk() was told, or 0.
  LogPlace place_of(Bytes message, uint64_t packed) const;

  MappedFile file_;
  uint64_t chunk_at_ = 0;  // whose content is in chunk_
  std::vector<uint8_t> chunk_;
};

// A little-endian number; the caller has seen that the bytes are there.
template <class T>
T little(const uint8_t* from) {
  T value = 0;
  for (size_t i = 0; i < sizeof(T); ++i) value = T(value | T(T(from[i]) << (8 * i)));
  return value;
}

}  // namespace pirvs::tools
