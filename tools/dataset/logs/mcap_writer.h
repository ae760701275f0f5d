// What    Writes an MCAP file of ROS 2 messages, as rosbag2, Foxglove and Lichtblick read it.
// In      Channels by topic and type ("nav_msgs/msg/Odometry"); messages in CDR (ros_writer.h), of
//         which those of one channel should come in order of time.
// Out     Chunks of about 1 MB, packed by zstd, each with an index of its messages; a summary with
//         schemas, channels, statistics and the index of the chunks.
// Units   ns since 1970 or since whatever the stamps count.
// Errors  The stream's own; its owner looks at it.
// Cost    ~1 us a message and what zstd takes, ~400 MB/s.
// Source  mcap.dev, "Format Specification"; docs/adr/0019.
#pragma once

#include <cstdint>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace pirvs::tools {

class McapWriter {
 public:
  using Channel = uint16_t;

  explicit McapWriter(std::ostream& out);
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  Channel add_channel(const std::string& topic, const std::string& type);
  void write(Channel channel, TimeNs t, const std::vector<uint8_t>& message);
  void finish();  // nothing may be written behind

  size_t messages() const { return messages_; }

 private:
  using Block = std::vector<uint8_t>;
  struct ChannelState {
    uint32_t sequence = 0;
    Block index;  // of this chunk: time and place of each message
  };
  struct Chunk {
    TimeNs first = 0, last = 0;
    uint64_t at = 0, size = 0, index_size = 0, packed = 0, unpacked = 0;
    std::map<Channel, uint64_t> index_at;
  };

  std::ostream& out_;
  uint64_t at_ = 0;
  std::map<std::string, uint16_t> schemas_;  // by type
  Block descriptions_[2];                    // records of all schemas, and of all channels
  std::vector<ChannelState> channels_;       // channel i + 1
  Block open_;                               // records of the chunk at hand
  Chunk chunk_;
  std::vector<Chunk> chunks_;
  size_t messages_ = 0;

  void emit(const Block& bytes);
  void close_chunk();
  Block statistics() const;
  Block chunk_index(const Chunk& chunk) const;
};

}  // namespace pirvs::tools
