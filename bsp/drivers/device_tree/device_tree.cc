#include "bsp/drivers/device_tree/device_tree.h"

#include <cstring>

namespace pirvs::bsp {
namespace {

constexpr uint32_t kMagic = 0xd00dfeed;
constexpr size_t kHeaderBytes = 40;
enum Token : uint32_t { kBeginNode = 1, kEndNode = 2, kProperty = 3, kNop = 4, kEnd = 9 };

uint32_t big_endian(const uint8_t* at) {
  uint32_t value;
  std::memcpy(&value, at, sizeof value);
  return __builtin_bswap32(value);
}

// A part of the blob that is read from front to back and never beyond its end.
struct Reader {
  const uint8_t* at;
  const uint8_t* end;

  size_t left() const { return static_cast<size_t>(end - at); }
  bool number(uint32_t& out) {
    if (left() < 4) return false;
    out = big_endian(at);
    at += 4;
    return true;
  }
  bool skip(size_t bytes) {
    const size_t padded = (bytes + 3) & ~size_t{3};
    if (left() < padded) return false;
    at += padded;
    return true;
  }
  bool skip_text() {
    const void* const zero = std::memchr(at, 0, left());
    return zero != nullptr && skip(static_cast<size_t>(static_cast<const uint8_t*>(zero) - at) + 1);
  }
};

struct Property {
  const char* name;
  const uint8_t* value;
  uint32_t bytes;

  bool is(const char* other) const { return std::strcmp(name, other) == 0; }
  bool text_is(const char* other) const {
    return bytes == std::strlen(other) + 1 && std::memcmp(value, other, bytes) == 0;
  }
  uint64_t number() const {
    if (bytes == 4) return big_endian(value);
    if (bytes != 8) return 0;
    return uint64_t{big_endian(value)} << 32 | big_endian(value + 4);
  }
};

void take(const Property& property, DeviceTree& out) {
  if (property.is("linux,initrd-start")) out.initrd_begin = property.number();
  if (property.is("linux,initrd-end")) out.initrd_end = property.number();
  if (property.is("method") && property.text_is("hvc")) out.firmware = FirmwareCall::kHvc;
  if (property.is("method") && property.text_is("smc")) out.firmware = FirmwareCall::kSmc;
  if (property.is("bootargs")) {
    const size_t size = property.bytes < out.kArgumentsMax ? property.bytes : out.kArgumentsMax - 1;
    std::memcpy(out.arguments, property.value, size);
    out.arguments[size] = 0;
  }
}

Status read_structure(Reader structure, const Reader& texts, DeviceTree& out) {
  for (;;) {
    uint32_t token;
    if (!structure.number(token)) return Status::kBadData;
    if (token == kEnd) return Status::kOk;
    if (token == kEndNode || token == kNop) continue;
    if (token == kBeginNode) {
      if (!structure.skip_text()) return Status::kBadData;
      continue;
    }
    uint32_t bytes;
    uint32_t name;
    if (token != kProperty || !structure.number(bytes) || !structure.number(name)) {
      return Status::kBadData;
    }
    const uint8_t* const value = structure.at;
    Reader text = texts;
    if (!structure.skip(bytes) || name >= text.left()) return Status::kBadData;
    text.at += name;
    const char* const name_text = reinterpret_cast<const char*>(text.at);
    if (std::memchr(text.at, 0, text.left()) == nullptr) return Status::kBadData;
    take({name_text, value, bytes}, out);
  }
}

}  // namespace

Status read_device_tree(const void* blob, DeviceTree& out) {
  out = DeviceTree{};
  const auto* const begin = static_cast<const uint8_t*>(blob);
  if (begin == nullptr || big_endian(begin) != kMagic) return Status::kNotFound;
  const size_t bytes = big_endian(begin + 4);
  const size_t structure = big_endian(begin + 8);
  const size_t texts = big_endian(begin + 12);
  if (bytes < kHeaderBytes || bytes > kDeviceTreeMax) return Status::kBadData;
  if (structure % 4 != 0 || structure > bytes || texts > bytes) return Status::kBadData;
  out.bytes = bytes;
  return read_structure({begin + structure, begin + bytes}, {begin + texts, begin + bytes}, out);
}

bool find_argument(const char* arguments, const char* name, char* value, size_t size) {
  const size_t name_size = std::strlen(name);
  for (const char* word = arguments; *word != 0;) {
    const char* end = word;
    while (*end != 0 && *end != ' ' && *end != '\n') ++end;
    const size_t word_size = static_cast<size_t>(end - word);
    const bool named = word_size >= name_size && std::memcmp(word, name, name_size) == 0;
    if (named && (word_size == name_size || word[name_size] == '=')) {
      const char* const from = word + name_size + (word_size > name_size ? 1 : 0);
      size_t length = static_cast<size_t>(end - from);
      if (length > size - 1) length = size - 1;
      std::memcpy(value, from, length);
      value[length] = 0;
      return true;
    }
    word = *end == 0 ? end : end + 1;
  }
  return false;
}

}  // namespace pirvs::bsp
