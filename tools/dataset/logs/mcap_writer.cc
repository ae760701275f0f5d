#include "tools/dataset/logs/mcap_writer.h"

#include <zstd.h>

#include <algorithm>

#include "tools/dataset/logs/ros_writer.h"

namespace pirvs::tools {
namespace {

using Block = std::vector<uint8_t>;

constexpr uint8_t kMagic[] = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
constexpr size_t kChunkBytes = 1 << 20;
constexpr const char* kCompression = "zstd";
constexpr int kLevel = 1;  // JPEG does not get smaller, all else does at once

enum Op : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

template <class T>
void put(Block& to, T value) {
  for (size_t i = 0; i < sizeof(T); ++i) to.push_back(uint8_t(uint64_t(value) >> (8 * i)));
}

void put_block(Block& to, const Block& bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

void put_text(Block& to, const std::string& text) {
  put(to, uint32_t(text.size()));
  to.insert(to.end(), text.begin(), text.end());
}

Block record(Op op, const Block& content) {
  Block out;
  out.reserve(content.size() + 9);
  put(out, uint8_t(op));
  put(out, uint64_t(content.size()));
  put_block(out, content);
  return out;
}

}  // namespace

McapWriter::McapWriter(std::ostream& out) : out_(out) {
  emit(Block(std::begin(kMagic), std::end(kMagic)));
  Block header;
  put_text(header, "ros2");
  put_text(header, "pirvs");
  emit(record(kHeader, header));
}

McapWriter::Channel McapWriter::add_channel(const std::string& topic, const std::string& type) {
  const auto [schema, is_new] = schemas_.try_emplace(type, uint16_t(schemas_.size() + 1));
  Block described;
  if (is_new) {
    Block content;
    put(content, schema->second);
    put_text(content, type);
    put_text(content, "ros2msg");
    put_text(content, ros_definition(type));
    described = record(kSchema, content);
    put_block(descriptions_[0], described);
  }
  channels_.emplace_back();
  const auto id = Channel(channels_.size());
  Block content;
  put(content, id);
  put(content, schema->second);
  put_text(content, topic);
  put_text(content, "cdr");
  put(content, uint32_t{0});  // no metadata
  put_block(descriptions_[1], record(kChannel, content));
  put_block(described, record(kChannel, content));
  put_block(open_, described);
  return id;
}

void McapWriter::write(Channel channel, TimeNs t, const std::vector<uint8_t>& message) {
  ChannelState& state = channels_.at(size_t(channel) - 1);
  put(state.index, uint64_t(t));
  put(state.index, uint64_t(open_.size()));
  Block head;
  put(head, channel);
  put(head, state.sequence++);
  put(head, uint64_t(t));
  put(head, uint64_t(t));  // logged and published at once
  put(open_, uint8_t(kMessage));
  put(open_, uint64_t(head.size() + message.size()));
  put_block(open_, head);
  put_block(open_, message);
  const bool first = chunk_.first == 0 && chunk_.last == 0;
  chunk_.first = first ? t : std::min(chunk_.first, t);
  chunk_.last = first ? t : std::max(chunk_.last, t);
  ++messages_;
  if (open_.size() >= kChunkBytes) close_chunk();
}

void McapWriter::emit(const Block& bytes) {
  out_.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  at_ += bytes.size();
}

void McapWriter::close_chunk() {
  if (open_.empty()) return;
  Block packed(ZSTD_compressBound(open_.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), open_.data(), open_.size(), kLevel));
  Block content;
  put(content, uint64_t(chunk_.first));
  put(content, uint64_t(chunk_.last));
  put(content, uint64_t(open_.size()));
  put(content, uint32_t{0});  // no checksum
  put_text(content, kCompression);
  put(content, uint64_t(packed.size()));
  put_block(content, packed);
  chunk_.at = at_;
  chunk_.packed = packed.size();
  chunk_.unpacked = open_.size();
  emit(record(kChunk, content));
  chunk_.size = at_ - chunk_.at;
  for (size_t i = 0; i < channels_.size(); ++i) {
    Block& rows = channels_[i].index;
    if (rows.empty()) continue;
    Block index;
    put(index, Channel(i + 1));
    put(index, uint32_t(rows.size()));
    put_block(index, rows);
    rows.clear();
    chunk_.index_at[Channel(i + 1)] = at_;
    emit(record(kMessageIndex, index));
  }
  chunk_.index_size = at_ - chunk_.at - chunk_.size;
  chunks_.push_back(chunk_);
  chunk_ = {};
  open_.clear();
}

Block McapWriter::statistics() const {
  TimeNs first = 0, last = 0;
  for (const Chunk& chunk : chunks_) {
    first = first == 0 ? chunk.first : std::min(first, chunk.first);
    last = std::max(last, chunk.last);
  }
  Block counts;
  for (size_t i = 0; i < channels_.size(); ++i) {
    put(counts, Channel(i + 1));
    put(counts, uint64_t(channels_[i].sequence));
  }
  Block out;
  put(out, uint64_t(messages_));
  put(out, uint16_t(schemas_.size()));
  put(out, uint32_t(channels_.size()));
  put(out, uint32_t{0});  // attachments
  put(out, uint32_t{0});  // metadata
  put(out, uint32_t(chunks_.size()));
  put(out, uint64_t(first));
  put(out, uint64_t(last));
  put(out, uint32_t(counts.size()));
  put_block(out, counts);
  return record(kStatistics, out);
}

Block McapWriter::chunk_index(const Chunk& chunk) const {
  Block places;
  for (const auto& [channel, at] : chunk.index_at) {
    put(places, channel);
    put(places, at);
  }
  Block out;
  put(out, uint64_t(chunk.first));
  put(out, uint64_t(chunk.last));
  put(out, chunk.at);
  put(out, chunk.size);
  put(out, uint32_t(places.size()));
  put_block(out, places);
  put(out, chunk.index_size);
  put_text(out, kCompression);
  put(out, chunk.packed);
  put(out, chunk.unpacked);
  return record(kChunkIndex, out);
}

void McapWriter::finish() {
  close_chunk();
  Block end;
  put(end, uint32_t{0});  // no checksum
  emit(record(kDataEnd, end));
  const uint64_t summary_at = at_;
  Block indexes;
  for (const Chunk& chunk : chunks_) put_block(indexes, chunk_index(chunk));
  Block offsets;
  const std::pair<Op, Block> groups[] = {{kSchema, descriptions_[0]},
                                         {kChannel, descriptions_[1]},
                                         {kStatistics, statistics()},
                                         {kChunkIndex, indexes}};
  for (const auto& [op, records] : groups) {
    if (records.empty()) continue;
    Block offset;
    put(offset, uint8_t(op));
    put(offset, at_);
    put(offset, uint64_t(records.size()));
    put_block(offsets, record(kSummaryOffset, offset));
    emit(records);
  }
  const uint64_t offsets_at = at_;
  emit(offsets);
  Block footer;
  put(footer, summary_at);
  put(footer, offsets_at);
  put(footer, uint32_t{0});  // no checksum
  emit(record(kFooter, footer));
  emit(Block(std::begin(kMagic), std::end(kMagic)));
}

}  // namespace pirvs::tools
