// A ROS 1 bag, read from front to end: its index is not needed, and is missing after a power cut.
#include <cstring>
#include <map>

#include "tools/dataset/input_error.h"
#include "tools/dataset/logs/mapped_file.h"

namespace pirvs::tools {
namespace {

constexpr char kMagic[] = "#ROSBAG V2.0\n";
constexpr size_t kMagicSize = sizeof kMagic - 1;

enum Op : uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

// name=value pairs, each behind its length.
class Fields {
 public:
  explicit Fields(Bytes bytes) {
    for (size_t at = 0; at + 4 <= bytes.size;) {
      const size_t size = little<uint32_t>(bytes.data + at);
      at += 4;
      if (size > bytes.size - at) break;
      const auto* const begin = bytes.data + at;
      const auto* const equals = static_cast<const uint8_t*>(std::memchr(begin, '=', size));
      at += size;
      if (equals == nullptr) continue;
      const std::string name(begin, equals);
      fields_[name] = {equals + 1, size_t(begin + size - equals - 1)};
    }
  }
  template <class T>
  T number(const char* name, T missing = T(-1)) const {
    const auto found = fields_.find(name);
    if (found == fields_.end() || found->second.size != sizeof(T)) return missing;
    return little<T>(found->second.data);
  }
  std::string text(const char* name) const {
    const auto found = fields_.find(name);
    if (found == fields_.end()) return "";
    return {reinterpret_cast<const char*>(found->second.data), found->second.size};
  }

 private:
  std::map<std::string, Bytes> fields_;
};

// A header and data, each behind its length.
struct Record {
  Bytes header, data;
};

bool next_record(Bytes bytes, size_t& at, Record& out) {
  for (Bytes* part : {&out.header, &out.data}) {
    if (bytes.size - at < 4) return false;
    part->size = little<uint32_t>(bytes.data + at);
    at += 4;
    if (part->size > bytes.size - at) return false;
    part->data = bytes.data + at;
    at += part->size;
  }
  return true;
}

class Bag : public ChunkedLog {
 public:
  using ChunkedLog::ChunkedLog;
  const char* kind() const override { return "ROS 1 bag"; }

  void scan(const std::function<void(const LogMessage&)>& visit) override {
    topics_.clear();
    connections_.clear();
    walk(file_.bytes(), kMagicSize, 0, false, visit);
  }

 private:
  std::map<uint32_t, size_t> connections_;  // topic of each

  // `packed`: 0, or where in the file the packed chunk lies that the bytes are of.
  void walk(Bytes bytes, size_t at, uint64_t packed, bool inside,
            const std::function<void(const LogMessage&)>& visit) {
    for (Record record; at < bytes.size;) {
      const size_t begin = at;
      if (!next_record(bytes, at, record)) {
        cut_off_ = true;
        return;
      }
      const Fields fields(record.header);
      switch (fields.number<uint8_t>("op")) {
        case kConnection:
          connect(fields, Fields(record.data));
          break;
        case kChunk:
          if (!inside) walk_chunk(fields, record.data, begin, visit);
          break;
        case kMessage: {
          const auto topic = connections_.find(fields.number<uint32_t>("conn"));
          if (topic == connections_.end()) break;
          const auto time = fields.number<uint64_t>("time", 0);
          LogMessage message;
          message.topic = topic->second;
          message.log_t = TimeNs(time & UINT32_MAX) * 1'000'000'000 + TimeNs(time >> 32);
          message.bytes = record.data;
          message.place = place_of(record.data, packed);
          visit(message);
          break;
        }
        default:
          break;
      }
    }
  }

  void connect(const Fields& record, const Fields& connection) {
    const auto id = record.number<uint32_t>("conn");
    if (connections_.count(id) != 0) return;
    connections_[id] = topics_.size();
    topics_.push_back({record.text("topic"), ros1_type(connection.text("type")), false});
  }

  void walk_chunk(const Fields& fields, Bytes data, uint64_t at,
                  const std::function<void(const LogMessage&)>& visit) {
    const std::string compression = fields.text("compression");
    if (compression == "none") {
      walk(data, 0, 0, true, visit);
      return;
    }
    open_chunk(at);
    walk(chunk(), 0, at, true, visit);
  }

  void open_chunk(uint64_t at) override {
    if (chunk_at_ == at) return;
    size_t next = size_t(at);
    Record record;
    chunk_at_ = 0;
    chunk_.clear();
    const Bytes all = file_.bytes();
    if (next >= all.size || !next_record(all, next, record)) return;
    const Fields fields(record.header);
    const std::string compression = fields.text("compression");
    unpack(compression, record.data, fields.number<uint32_t>("size", 0), file_.path(), chunk_);
    chunk_at_ = at;
  }
};

}  // namespace

std::unique_ptr<LogFile> open_bag(const std::string& path) { return std::make_unique<Bag>(path); }

}  // namespace pirvs::tools
