#include "tools/dataset/logs/mapped_file.h"

#include <bzlib.h>
#include <fcntl.h>
#include <lz4frame.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

bool unpack_lz4(Bytes packed, std::vector<uint8_t>& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return false;
  size_t in = 0, done = 0, left = 1;
  while (left != 0 && in < packed.size) {
    size_t room = out.size() - done, take = packed.size - in;
    left = LZ4F_decompress(context, out.data() + done, &room, packed.data + in, &take, nullptr);
    if (LZ4F_isError(left) || (room == 0 && take == 0)) break;
    done += room;
    in += take;
  }
  LZ4F_freeDecompressionContext(context);
  return left == 0 && done == out.size();
}

bool unpack_bz2(Bytes packed, std::vector<uint8_t>& out) {
  unsigned size = unsigned(out.size());
  auto* const from = const_cast<char*>(reinterpret_cast<const char*>(packed.data));
  auto* const to = reinterpret_cast<char*>(out.data());
  const int result = BZ2_bzBuffToBuffDecompress(to, &size, from, unsigned(packed.size), 0, 0);
  return result == BZ_OK && size == out.size();
}

bool unpack_zstd(Bytes packed, std::vector<uint8_t>& out) {
  const size_t size = ZSTD_decompress(out.data(), out.size(), packed.data, packed.size);
  return ZSTD_isError(size) == 0 && size == out.size();
}

}  // namespace

MappedFile::MappedFile(const std::string& path) : path_(path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status = {};
  if (fd < 0 || fstat(fd, &status) != 0) {
    if (fd >= 0) close(fd);
    throw InputError("cannot read", path, "check the path and its permissions");
  }
  bytes_.size = size_t(status.st_size);
  if (bytes_.size > 0) {
    void* const at = mmap(nullptr, bytes_.size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (at != MAP_FAILED) bytes_.data = static_cast<const uint8_t*>(at);
  }
  close(fd);
  if (bytes_.size > 0 && bytes_.data == nullptr) {
    throw InputError("cannot read", path, "check the path and its permissions");
  }
}

MappedFile::~MappedFile() {
  if (bytes_.data != nullptr) munmap(const_cast<uint8_t*>(bytes_.data), bytes_.size);
}

void unpack(const std::string& compression, Bytes packed, uint64_t size, const std::string& path,
            std::vector<uint8_t>& out) {
  constexpr uint64_t kChunk_max = uint64_t{1} << 30, kRatio_max = 1000, kSmall = 1 << 20;
  const bool bad = size > kChunk_max || size > kSmall + kRatio_max * packed.size;
  out.resize(bad ? 0 : size_t(size));
  bool good = !bad;
  if (compression == "lz4") {
    good = good && unpack_lz4(packed, out);
  } else if (compression == "bz2") {
    good = good && unpack_bz2(packed, out);
  } else if (compression == "zstd") {
    good = good && unpack_zstd(packed, out);
  } else {
    throw InputError("a compression that is not known here, " + compression, path,
                     "write the log with lz4, zstd or none");
  }
  if (!good)
    throw InputError("a damaged chunk", path, "repair the log: rosbag reindex, mcap recover");
}

Bytes ChunkedLog::load(const LogPlace& place) {
  if (place.chunk != 0) open_chunk(place.chunk);
  const Bytes all = place.chunk != 0 ? chunk() : file_.bytes();
  if (place.at > all.size || place.size > all.size - place.at) return {};
  return {all.data + place.at, size_t(place.size)};
}

LogPlace ChunkedLog::place_of(Bytes message, uint64_t packed) const {
  const uint8_t* const base = packed != 0 ? chunk_.data() : file_.bytes().data;
  return {packed, uint64_t(message.data - base), message.size};
}

}  // namespace pirvs::tools
