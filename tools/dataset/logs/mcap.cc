// An MCAP file, read from front to end: its summary is not needed, and is missing after a power
// cut.
#include <cstring>
#include <map>

#include "tools/dataset/input_error.h"
#include "tools/dataset/logs/mapped_file.h"

namespace pirvs::tools {
namespace {

constexpr size_t kMagicSize = 8;
constexpr size_t kRecordHead = 9;  // its kind and length

enum Op : uint8_t { kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6 };

// The fields of a record, from left to right; what is not there is zero, and good() false.
class Fields {
 public:
  explicit Fields(Bytes bytes) : bytes_(bytes) {}
  template <class T>
  T number() {
    if (bytes_.size - at_ < sizeof(T)) return fail<T>();
    const T out = little<T>(bytes_.data + at_);
    at_ += sizeof(T);
    return out;
  }
  std::string text() {
    const Bytes all = block(number<uint32_t>());
    return {reinterpret_cast<const char*>(all.data), all.size};
  }
  Bytes block(uint64_t size) {
    if (size > bytes_.size - at_) return fail<Bytes>();
    const Bytes out = {bytes_.data + at_, size_t(size)};
    at_ += size_t(size);
    return out;
  }
  Bytes rest() { return block(bytes_.size - at_); }
  bool good() const { return good_; }

 private:
  Bytes bytes_;
  size_t at_ = 0;
  bool good_ = true;

  template <class T>
  T fail() {
    good_ = false;
    at_ = bytes_.size;
    return T{};
  }
};

class Mcap : public ChunkedLog {
 public:
  using ChunkedLog::ChunkedLog;
  const char* kind() const override { return "MCAP"; }

  void scan(const std::function<void(const LogMessage&)>& visit) override {
    topics_.clear();
    channels_.clear();
    schemas_.clear();
    walk(file_.bytes(), kMagicSize, 0, false, visit);
  }

 private:
  std::map<uint16_t, std::string> schemas_;  // the type's name of each
  std::map<uint16_t, size_t> channels_;      // topic of each

  void walk(Bytes bytes, size_t at, uint64_t packed, bool inside,
            const std::function<void(const LogMessage&)>& visit) {
    while (at < bytes.size) {
      const bool trailer = !inside && bytes.size - at == kMagicSize;
      if (trailer) return;  // the magic once more
      if (bytes.size - at < kRecordHead) break;
      const uint8_t op = bytes.data[at];
      const auto size = little<uint64_t>(bytes.data + at + 1);
      at += kRecordHead;
      if (size > bytes.size - at) break;
      const Bytes record = {bytes.data + at, size_t(size)};
      if (op == kChunk && !inside) {
        walk_chunk(record, at, visit);
      } else if (op == kSchema || op == kChannel) {
        describe(op, record);
      } else if (op == kMessage) {
        tell(record, packed, visit);
      }
      at += size_t(size);
    }
    if (at < bytes.size) cut_off_ = true;
  }

  void describe(uint8_t op, Bytes record) {
    Fields fields(record);
    const auto id = fields.number<uint16_t>();
    if (op == kSchema) {
      schemas_[id] = fields.text();
      return;
    }
    const auto schema = fields.number<uint16_t>();
    const std::string topic = fields.text(), encoding = fields.text();
    if (!fields.good() || channels_.count(id) != 0) return;
    channels_[id] = topics_.size();
    const auto type = schemas_.find(schema);
    topics_.push_back(
        {topic, ros1_type(type == schemas_.end() ? "" : type->second), encoding == "cdr"});
    if (encoding != "cdr" && encoding != "ros1") topics_.back().type += " as " + encoding;
  }

  void tell(Bytes record, uint64_t packed, const std::function<void(const LogMessage&)>& visit) {
    Fields fields(record);
    const auto topic = channels_.find(fields.number<uint16_t>());
    (void)fields.number<uint32_t>();  // sequence
    LogMessage message;
    message.log_t = TimeNs(fields.number<uint64_t>());
    (void)fields.number<uint64_t>();  // when it was published
    message.bytes = fields.rest();
    if (!fields.good() || topic == channels_.end()) return;
    message.topic = topic->second;
    message.place = place_of(message.bytes, packed);
    visit(message);
  }

  // Start, end, size, checksum, compression, records.
  static Bytes records_of(Bytes chunk, std::string& compression, uint64_t& size) {
    Fields fields(chunk);
    (void)fields.number<uint64_t>();
    (void)fields.number<uint64_t>();
    size = fields.number<uint64_t>();
    (void)fields.number<uint32_t>();
    compression = fields.text();
    const auto packed = fields.number<uint64_t>();
    const Bytes out = fields.block(packed);
    return fields.good() ? out : Bytes{};
  }

  void walk_chunk(Bytes record, size_t at, const std::function<void(const LogMessage&)>& visit) {
    std::string compression;
    uint64_t size = 0;
    const Bytes records = records_of(record, compression, size);
    if (compression.empty()) {
      walk(records, 0, 0, true, visit);
      return;
    }
    open_chunk(at);
    walk(chunk(), 0, at, true, visit);
  }

  // `at`: where the record's content begins.
  void open_chunk(uint64_t at) override {
    if (chunk_at_ == at) return;
    chunk_at_ = 0;
    chunk_.clear();
    const Bytes all = file_.bytes();
    if (at < kRecordHead || at > all.size) return;
    const auto length = little<uint64_t>(all.data + at - sizeof(uint64_t));
    if (length > all.size - at) return;
    std::string compression;
    uint64_t size = 0;
    const Bytes records = records_of({all.data + at, size_t(length)}, compression, size);
    unpack(compression, records, size, file_.path(), chunk_);
    chunk_at_ = at;
  }
};

}  // namespace

std::unique_ptr<LogFile> open_mcap(const std::string& path) { return std::make_unique<Mcap>(path); }

}  // namespace pirvs::tools
