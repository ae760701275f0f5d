// The wire: checksums, frames against noise and loss, what lies where in a message.
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "modules/link/mavlink_messages.h"

namespace pirvs::mavlink {
namespace {

using Bytes = std::vector<uint8_t>;

template <class Message>
Bytes frame_of(const Message& message, Sender sender = {}) {
  uint8_t out[kFrameMax];
  const size_t size = encode(message, sender, out);
  return {out, out + size};
}

void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

std::vector<Frame> parse(FrameParser& parser, const Bytes& bytes, size_t piece = 1) {
  std::vector<Frame> out;
  for (size_t at = 0; at < bytes.size();) {
    const size_t taken = parser.push(bytes.data() + at, std::min(piece, bytes.size() - at));
    EXPECT_GT(taken, 0u);
    at += taken;
    for (Frame frame; parser.next(frame);) out.push_back(frame);
  }
  return out;
}

std::vector<Frame> parse(const Bytes& bytes, size_t piece = 1) {
  FrameParser parser;
  return parse(parser, bytes, piece);
}

Odometry some_odometry() {
  Odometry out;
  out.time_usec = 0x0102'0304'0506'0708;
  for (int i = 0; i < 3; ++i) out.x_m[i] = static_cast<float>(i + 1);
  for (int i = 0; i < 21; ++i) out.pose_covariance[i] = static_cast<float>(i) + 0.5f;
  out.reset_counter = 7;
  out.quality = -1;
  return out;
}

uint16_t checksum(const void* data, size_t size, uint16_t sum = 0xFFFF) {
  for (size_t i = 0; i < size; ++i) {  // bit by bit, as the definition says
    sum = static_cast<uint16_t>(sum ^ static_cast<const uint8_t*>(data)[i]);
    for (int bit = 0; bit < 8; ++bit) {
      sum = static_cast<uint16_t>((sum & 1) != 0 ? sum >> 1 ^ 0x8408 : sum >> 1);
    }
  }
  return sum;
}

// "type name" each, arrays "type name[n]": as common.xml has them, without extensions.
uint8_t crc_extra(const std::string& name, const std::vector<std::string>& fields) {
  const std::string head = name + " ";
  uint16_t sum = checksum(head.data(), head.size());
  for (const std::string& field : fields) {
    const size_t bracket = field.find('[');
    const std::string plain = field.substr(0, bracket) + " ";
    sum = checksum(plain.data(), plain.size(), sum);
    if (bracket == std::string::npos) continue;
    const auto count = static_cast<uint8_t>(std::stoi(field.substr(bracket + 1)));
    sum = checksum(&count, 1, sum);
  }
  return static_cast<uint8_t>((sum & 0xFF) ^ sum >> 8);
}

TEST(mavlink, the_extra_checksum_is_that_of_each_definition) {
  EXPECT_EQ(Heartbeat::kKind.crc_extra,
            crc_extra("HEARTBEAT",
                      {"uint32_t custom_mode", "uint8_t type", "uint8_t autopilot",
                       "uint8_t base_mode", "uint8_t system_status", "uint8_t mavlink_version"}));
  EXPECT_EQ(Timesync::kKind.crc_extra, crc_extra("TIMESYNC", {"int64_t tc1", "int64_t ts1"}));
  EXPECT_EQ(Odometry::kKind.crc_extra,
            crc_extra("ODOMETRY", {"uint64_t time_usec", "float x", "float y", "float z",
                                   "float q[4]", "float vx", "float vy", "float vz",
                                   "float rollspeed", "float pitchspeed", "float yawspeed",
                                   "float pose_covariance[21]", "float velocity_covariance[21]",
                                   "uint8_t frame_id", "uint8_t child_frame_id"}));
  EXPECT_EQ(VisionPositionEstimate::kKind.crc_extra,
            crc_extra("VISION_POSITION_ESTIMATE", {"uint64_t usec", "float x", "float y", "float z",
                                                   "float roll", "float pitch", "float yaw"}));
  EXPECT_EQ(VisionSpeedEstimate::kKind.crc_extra,
            crc_extra("VISION_SPEED_ESTIMATE", {"uint64_t usec", "float x", "float y", "float z"}));
  EXPECT_EQ(CommandLong::kKind.crc_extra,
            crc_extra("COMMAND_LONG", {"float param1", "float param2", "float param3",
                                       "float param4", "float param5", "float param6",
                                       "float param7", "uint16_t command", "uint8_t target_system",
                                       "uint8_t target_component", "uint8_t confirmation"}));
  EXPECT_EQ(CommandAck::kKind.crc_extra,
            crc_extra("COMMAND_ACK", {"uint16_t command", "uint8_t result"}));
  EXPECT_EQ(StatusText::kKind.crc_extra,
            crc_extra("STATUSTEXT", {"uint8_t severity", "char text[50]"}));
  EXPECT_EQ(
      GpsRawInt::kKind.crc_extra,
      crc_extra("GPS_RAW_INT", {"uint64_t time_usec", "int32_t lat", "int32_t lon", "int32_t alt",
                                "uint16_t eph", "uint16_t epv", "uint16_t vel", "uint16_t cog",
                                "uint8_t fix_type", "uint8_t satellites_visible"}));
  EXPECT_EQ(GpsInput::kKind.crc_extra,
            crc_extra("GPS_INPUT",
                      {"uint64_t time_usec", "uint32_t time_week_ms", "int32_t lat", "int32_t lon",
                       "float alt", "float hdop", "float vdop", "float vn", "float ve", "float vd",
                       "float speed_accuracy", "float horiz_accuracy", "float vert_accuracy",
                       "uint16_t ignore_flags", "uint16_t time_week", "uint8_t gps_id",
                       "uint8_t fix_type", "uint8_t satellites_visible"}));
  EXPECT_EQ(
      WheelDistance::kKind.crc_extra,
      crc_extra("WHEEL_DISTANCE", {"uint64_t time_usec", "double distance[16]", "uint8_t count"}));
}

TEST(mavlink, a_frame_is_what_the_specification_says) {
  Sender sender{9, kComponent, 33};
  Heartbeat message;
  message.system_status = kStateActive;
  const Bytes bytes = frame_of(message, sender);
  const Bytes head = {0xFD, 9, 0, 0, 33, 9, 197, 0, 0, 0, 0, 0, 0, 0, 18, 8, 0, 4, 3};
  ASSERT_EQ(bytes.size(), head.size() + 2);
  EXPECT_TRUE(std::equal(head.begin(), head.end(), bytes.begin()));
  uint16_t sum = checksum(head.data() + 1, head.size() - 1);
  sum = checksum(&Heartbeat::kKind.crc_extra, 1, sum);
  EXPECT_EQ(bytes[19] | bytes[20] << 8, sum);
}

TEST(mavlink, fields_lie_where_the_table_says) {
  const Bytes bytes = frame_of(some_odometry());
  const uint8_t* const payload = bytes.data() + kHeaderBytes;
  ASSERT_EQ(bytes[1], 233);
  EXPECT_EQ(payload[0], 8);  // time_usec, its lowest byte
  const auto number = [&](size_t at) {
    float x = 0;
    std::memcpy(&x, payload + at, sizeof x);
    return x;
  };
  EXPECT_EQ(number(8), 1);
  EXPECT_EQ(number(20), 1);  // q, w first
  EXPECT_EQ(number(60), 0.5f);
  EXPECT_EQ(number(60 + 4 * 20), 20.5f);
  EXPECT_EQ(payload[228], kFrameLocalFrd);
  EXPECT_EQ(payload[229], kFrameBodyFrd);
  EXPECT_EQ(payload[230], 7);
  EXPECT_EQ(payload[231], kEstimatorVio);
  EXPECT_EQ(payload[232], 0xFF);
}

TEST(mavlink, zeros_at_the_end_are_cut_and_come_back) {
  Odometry message = some_odometry();
  message.quality = 0;
  EXPECT_EQ(frame_of(message)[1], 232);
  const std::vector<Frame> frames = parse(frame_of(message));
  ASSERT_EQ(frames.size(), 1u);
  Odometry out;
  out.quality = 55;
  ASSERT_TRUE(decode(frames[0], out));
  EXPECT_EQ(out.quality, 0);
  EXPECT_EQ(out.pose_covariance[20], 20.5f);
  EXPECT_EQ(frame_of(Timesync{})[1], 1) << "one byte stays";
  Heartbeat other;
  EXPECT_FALSE(decode(frames[0], other)) << "another message";
}

TEST(mavlink, a_payload_longer_than_ours_is_of_a_newer_dialect) {
  const MessageKind longer = {Heartbeat::kKind.id, Heartbeat::kKind.crc_extra, 14};
  uint8_t payload[14], bytes[kFrameMax];
  std::memset(payload, 5, sizeof payload);
  Sender sender;
  const size_t size = write_frame(longer, payload, sender, bytes);
  const std::vector<Frame> frames = parse({bytes, bytes + size});
  ASSERT_EQ(frames.size(), 1u);
  Heartbeat out;
  ASSERT_TRUE(decode(frames[0], out));
  EXPECT_EQ(out.mavlink_version, 5);
}

TEST(mavlink, frames_come_out_whatever_pieces_they_come_in) {
  Bytes bytes;
  for (int i = 0; i < 20; ++i) append(bytes, frame_of(some_odometry()));
  for (const size_t piece : {1, 2, 7, 11, 279, 5000}) {
    EXPECT_EQ(parse(bytes, piece).size(), 20u) << piece;
  }
}

// Noise in front of each of 2000 frames, one byte in eight of it the start of a frame.
TEST(mavlink, noise_costs_hardly_a_frame) {
  std::mt19937 random(7);
  size_t found = 0, skipped = 0;
  for (int round = 0; round < 200; ++round) {
    FrameParser parser;
    Bytes bytes;
    for (int i = 0; i < 10; ++i) {
      const size_t noise = random() % 40;
      for (size_t k = 0; k < noise; ++k) {
        const uint32_t r = random();
        bytes.push_back(static_cast<uint8_t>((r & 0x700) != 0 ? r : 0xFD + (r & 1)));
      }
      append(bytes, frame_of(some_odometry()));
    }
    append(bytes, Bytes(kFrameMax, 0));  // what a false start was waiting for
    found += parse(parser, bytes, 1 + random() % 300).size();
    skipped += parser.counters().bytes_skipped;
  }
  EXPECT_GE(found, 1999u);
  EXPECT_GT(skipped, 30'000u);
}

TEST(mavlink, a_frame_that_was_cut_short_costs_itself_alone) {
  for (size_t cut = 1; cut < 240; cut += 7) {
    Bytes bytes = frame_of(some_odometry());
    bytes.resize(bytes.size() - cut);
    append(bytes, frame_of(some_odometry()));
    append(bytes, frame_of(some_odometry()));
    append(bytes, Bytes(kFrameMax, 0));
    FrameParser parser;
    EXPECT_EQ(parse(parser, bytes, 16).size(), 2u) << cut;
  }
}

TEST(mavlink, a_flipped_bit_is_noticed) {
  const Bytes good = frame_of(some_odometry());
  for (size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes bytes = good;
    bytes[bit / 8] = static_cast<uint8_t>(bytes[bit / 8] ^ 1 << bit % 8);
    if (bit / 8 == 3) continue;  // compatible flags mean nothing, but are summed
    append(bytes, Bytes(kFrameMax, 0));
    EXPECT_TRUE(parse(bytes, 64).empty()) << bit;
  }
}

TEST(mavlink, a_signature_is_tolerated_other_flags_are_refused) {
  Bytes bytes = frame_of(some_odometry());
  bytes[2] = 1;
  const size_t end = bytes.size() - 2;
  uint16_t sum = checksum(bytes.data() + 1, end - 1);
  sum = checksum(&Odometry::kKind.crc_extra, 1, sum);
  bytes[end] = static_cast<uint8_t>(sum);
  bytes[end + 1] = static_cast<uint8_t>(sum >> 8);
  bytes.insert(bytes.end(), 13, 0xFD);
  append(bytes, frame_of(some_odometry()));
  FrameParser parser;
  const std::vector<Frame> frames = parse(parser, bytes);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_TRUE(frames[0].is_signed);
  EXPECT_FALSE(frames[1].is_signed);
  EXPECT_EQ(parser.counters().signature_ignored, 1u);
  Bytes other = frame_of(some_odometry());
  other[2] = 2;
  append(other, Bytes(kFrameMax, 0));
  EXPECT_TRUE(parse(parser, other).empty());
  EXPECT_EQ(parser.counters().flags_refused, 1u);
}

TEST(mavlink, version_1_and_strange_messages_are_skipped_whole) {
  Bytes bytes = {0xFE, 9, 0, 1, 1, 0};  // a HEARTBEAT whose payload looks like the start of frames
  bytes.insert(bytes.end(), 9, 0xFD);
  uint16_t sum = checksum(bytes.data() + 1, bytes.size() - 1);
  sum = checksum(&Heartbeat::kKind.crc_extra, 1, sum);
  bytes.push_back(static_cast<uint8_t>(sum));
  bytes.push_back(static_cast<uint8_t>(sum >> 8));
  uint8_t payload[30], attitude[kFrameMax];
  std::memset(payload, 0xFD, sizeof payload);
  Sender sender;
  const size_t size = write_frame({30, 39, 28}, payload, sender, attitude);
  append(bytes, {attitude, attitude + size});
  append(bytes, frame_of(Heartbeat{}));
  FrameParser parser;
  EXPECT_EQ(parse(parser, bytes).size(), 1u);
  EXPECT_EQ(parser.counters().version_1, 1u);
  EXPECT_EQ(parser.counters().unknown, 1u);
  EXPECT_EQ(parser.counters().bytes_skipped, 0u);
}

}  // namespace
}  // namespace pirvs::mavlink
