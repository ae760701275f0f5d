#include "tests/fuzz/targets.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "board/linux/settings.h"
#include "board/linux/text_commands.h"
#include "bsp/drivers/device_tree/device_tree.h"
#include "bsp/replay/pack.h"
#include "bsp/replay/sensors.h"
#include "core/base/assert.h"
#include "modules/app/intake.h"
#include "modules/calibration/calibration_check.h"
#include "modules/calibration/calibration_text.h"
#include "modules/door/door.h"
#include "modules/gnss/receiver_clock.h"
#include "modules/gnss/receiver_reader.h"
#include "modules/link/link.h"
#include "tools/dataset/assemble.h"
#include "tools/dataset/calibration/rig_file.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/gnss_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/logs/log_rig.h"
#include "tools/dataset/loose_tables.h"
#include "tools/dataset/order_file.h"
#include "tools/dataset/recording.h"
#include "tools/dataset/sensor_tables.h"
#include "tools/dataset/trajectory.h"
#include "tools/run/fault.h"
#include "tools/run/parameters.h"

namespace pirvs::fuzz {
namespace {

using tools::InputError;

// The bytes as a file that needs no disk.
class MemoryFile {
 public:
  MemoryFile(const uint8_t* data, size_t size) : fd_(memfd_create("fuzz", MFD_CLOEXEC)) {
    PIRVS_ASSERT(fd_ >= 0 && write(fd_, data, size) == ssize_t(size));
  }
  ~MemoryFile() { close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

// Every refusal is one line.
template <class Parse>
void expect_result_or_refusal(Parse&& parse) {
  try {
    parse();
  } catch (const InputError& error) {
    PIRVS_ASSERT(std::strlen(error.what()) > 0);
  }
}

void imu_csv(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    tools::InputLog log;
    const auto samples = tools::read_imu_samples(file.path(), log);
    PIRVS_ASSERT(!samples.empty());
    for (size_t i = 0; i < samples.size(); ++i) {
      PIRVS_ASSERT(samples[i].w_B.allFinite() && samples[i].f_B.allFinite());
      PIRVS_ASSERT(i == 0 || samples[i].t > samples[i - 1].t);
    }
  });
}

void image_list(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    tools::InputLog log;
    const auto images = tools::read_image_list(file.path(), log);
    PIRVS_ASSERT(!images.empty());
    for (size_t i = 1; i < images.size(); ++i) PIRVS_ASSERT(images[i].t > images[i - 1].t);
  });
}

// What lies beside a video: stamps of frames, and one sensor's samples.
void loose_table(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    const auto table = tools::open_frame_stamps(file.path(), {tools::kCameraRates, {}, {}});
    while (table->next()) (void)table->stamp();
  });
  expect_result_or_refusal([&] {
    tools::InputLog log;
    tools::TextTable table(file.path(), "gyro samples", {tools::kImuRates, {}, {}});
    auto samples = tools::read_triples(table, &ImuSample::w_B, file.path(), log);
    tools::put_gyro_first(samples, log);
    for (size_t i = 1; i < samples.size(); ++i) PIRVS_ASSERT(samples[i].t > samples[i - 1].t);
    const auto both = tools::join_sensors(samples, samples);
    for (const ImuSample& sample : both) PIRVS_ASSERT(sample.f_B.allFinite());
  });
}

void order_csv(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    for (const OrderRow& row : tools::read_order(file.path())) {
      Text<kOrderRowMax + 1> text;
      put(text, row);
      PIRVS_ASSERT(!text.full() && arrival_of(row).kind == row.kind);
    }
  });
  expect_result_or_refusal([&] { (void)tools::read_maps(file.path()); });
}

void expect_usable(const Calibration& calibration) {
  const CalibrationFault fault = find_fault(calibration);
  if (fault) return;
  for (int c = 0; c < calibration.cameras; ++c) {
    Vec2 uv;
    const Camera& camera = calibration.camera[c];
    PIRVS_ASSERT(camera.project(Vec3(0, 0, 1), uv) && uv.allFinite());
  }
}

void sensor_yaml(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    Calibration calibration;
    calibration.cameras = 1;
    const tools::RigCamera read = tools::read_asl_sensor(tools::Document(file.path()));
    const tools::LensFit lens = tools::fit(read.lens);
    if (!lens.exact && !(lens.error_px < 1)) return;
    calibration.camera[0] = lens.camera;
    calibration.camera[0].T_BC = read.T_BC;
    expect_usable(calibration);
  });
  expect_result_or_refusal([&] { (void)tools::find_noise(file.path()); });
}

// Whichever family the keys say.
void rig_file(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    tools::InputLog log;
    expect_usable(tools::read_rig(file.path(), {}, log).calibration);
  });
}

// What a RealSense prints, for images of a size that it may have.
void realsense(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    const tools::RigFile rig = tools::read_realsense(file.path());
    tools::InputLog log;
    tools::RigOptions options;
    const tools::Lens& lens = rig.cameras.at(0).lens;
    options.image_size = [&] { return std::pair(lens.width, lens.height); };
    expect_usable(tools::make_rig(rig, file.path(), options, log).calibration);
  });
}

// Messages of a log that says its rig itself, of either encoding: CameraInfo of two cameras, each
// with its size in front, and transforms.
void camera_info(const uint8_t* data, size_t size) {
  if (size < 1) return;
  const bool cdr = data[0] % 2 == 1;
  tools::Bytes rest{data + 1, size - 1};
  const auto next = [&] {
    const size_t wanted = rest.size < 2 ? 0 : rest.data[0] + size_t{256} * rest.data[1];
    const size_t head = std::min<size_t>(2, rest.size);
    const size_t bytes = std::min(wanted, rest.size - head);
    const tools::Bytes out{rest.data + head, bytes};
    rest = {rest.data + head + bytes, rest.size - head - bytes};
    return out;
  };
  expect_result_or_refusal([&] {
    std::vector<tools::LogCamera> cameras;
    for (const char* topic :
         {"/left/image_raw", data[0] & 2 ? "/right/image_rect" : "/right/image"}) {
      tools::CameraInfo info;
      if (!tools::decode_camera_info(next(), cdr, info)) continue;
      cameras.push_back({topic, info.frame_id, tools::info_topic_of(topic), info});
    }
    std::vector<tools::RosTransform> transforms;
    (void)tools::decode_transforms(rest, cdr, transforms);
    if (cameras.empty()) return;
    const std::string imu = data[0] & 4 ? cameras[0].frame_id : "imu";
    const tools::RigFile rig = tools::rig_of_log("log", cameras, imu, transforms);
    tools::InputLog log;
    expect_usable(tools::make_rig(rig, "log", {}, log).calibration);
  });
}

// A bag or an MCAP file, as its first bytes say, each message decoded as what its topic is.
void log(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    const auto log = tools::open_log(file.path());
    if (!log) return;
    std::vector<tools::LogPlace> places;
    log->scan([&](const tools::LogMessage& message) {
      const tools::LogTopic& topic = log->topics().at(message.topic);
      ImuSample sample;
      tools::TrajectoryPose pose;
      cv::Mat grey;
      (void)tools::decode_imu(message.bytes, topic.cdr, sample);
      (void)tools::decode_image(message.bytes, topic.cdr, grey);
      (void)tools::compressed_image(message.bytes, topic.cdr);
      (void)tools::decode_pose(topic.type, message.bytes, topic.cdr, pose);
      if (places.size() < 100) places.push_back(message.place);
    });
    for (const tools::LogPlace& place : places) {
      PIRVS_ASSERT(log->load(place).size == place.size);
    }
  });
}

void trajectory(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  expect_result_or_refusal([&] {
    const tools::Trajectory read = tools::read_trajectory(file.path());
    PIRVS_ASSERT(!read.poses.empty());
    for (const tools::TrajectoryPose& pose : read.poses) {
      PIRVS_ASSERT(pose.p_WB.allFinite() && std::abs(pose.q_WB.norm() - 1) < 1e-6);
      PIRVS_ASSERT(!tools::tum_line(pose.t, pose.p_WB, pose.q_WB).empty());
    }
  });
}

void parameter(const uint8_t* data, size_t size) {
  const std::string assignment(reinterpret_cast<const char*>(data), size);
  expect_result_or_refusal([&] {
    AppParams params;
    tools::set_parameter(params, assignment);
    PIRVS_ASSERT(!tools::list_parameters(params, true).empty());
  });
}

void fault(const uint8_t* data, size_t size) {
  const std::string spec(reinterpret_cast<const char*>(data), size);
  expect_result_or_refusal([&] {
    const tools::Fault fault = tools::parse_fault(spec);
    PIRVS_ASSERT(fault.kind < tools::FaultKind::kCount && std::isfinite(fault.value));
    PIRVS_ASSERT(fault.begin >= 0 && fault.end > fault.begin);
  });
}

// The bytes where a loader puts a pack: aligned, and nothing behind them.
class LoadedPack {
 public:
  LoadedPack(const uint8_t* data, size_t size)
      : size_(size), bytes_(static_cast<uint8_t*>(::operator new(size, kAlign))) {
    if (size > 0) std::memcpy(bytes_, data, size);
  }
  ~LoadedPack() { ::operator delete(bytes_, kAlign); }
  LoadedPack(const LoadedPack&) = delete;
  LoadedPack& operator=(const LoadedPack&) = delete;

  const uint8_t* data() const { return bytes_; }
  size_t size() const { return size_; }
  // Guessing a checksum would keep the fuzzer busy for ever.
  void make_header_right() {
    if (size_ < sizeof(bsp::PackHeader)) return;
    bsp::PackHeader& header = *reinterpret_cast<bsp::PackHeader*>(bytes_);
    std::memcpy(header.magic, bsp::kPackMagic, sizeof header.magic);
    header.version = bsp::kPackVersion;
    header.header_bytes = sizeof header;
    header.bytes = size_ - size_ % 8;
    header.checksum = bsp::pack_checksum(bytes_, header.bytes);
  }

 private:
  static constexpr std::align_val_t kAlign{bsp::kPackAlign};
  size_t size_;
  uint8_t* bytes_;
};

// Whatever a recording says, the door hands out one stream in order.
void play_through_the_door(bsp::Pack& pack) {
  Calibration calibration;
  for (int c = 0; c < 2; ++c) calibration.camera[c] = pack.camera(c);
  expect_usable(calibration);
  calibration.camera_time_offset_ns = pack.header().camera_time_offset_ns % 1'000'000'000;
  const auto door = std::make_unique<Door>();
  DoorListener listener;
  listener.release = Intake::release;
  door->configure(calibration, DoorParams{}, listener);
  Intake intake;
  intake.configure(door.get());
  bsp::play(pack.source(), bsp::ReplayPace::kFast);
  DoorItem item, before;
  bool first = true;
  uint64_t pixels = 0;
  const auto next = [&] {
    for (;;) {
      const Status status = door->next(item);
      if (status != Status::kEmpty || !intake.poll()) return status;
    }
  };
  for (Status status; (status = next()) != Status::kStale; first = false) {
    PIRVS_ASSERT(status == Status::kOk);
    if (item.is_frame()) {
      PIRVS_ASSERT(!first && !before.is_frame() && item.frame.t == before.imu.t);
      for (const ImageView& image : item.frame.images.image) {
        for (int y = 0; y < image.height; ++y) pixels += image.row(y)[image.width - 1];
      }
      door->release();
    } else {
      PIRVS_ASSERT(item.imu.w_B.allFinite() && item.imu.f_B.allFinite());
      const TimeNs t_before = before.is_frame() ? before.frame.t : before.imu.t;
      PIRVS_ASSERT(first || item.broken || item.imu.t > t_before);
    }
    before = item;
  }
  PIRVS_ASSERT(pixels < UINT64_MAX);  // they have been read
}

void pack(const uint8_t* data, size_t size) {
  LoadedPack loaded(data, size);
  bsp::Pack opened;
  (void)opened.open(loaded.data(), loaded.size());
  loaded.make_header_right();
  if (opened.open(loaded.data(), loaded.size()) == Status::kOk) play_through_the_door(opened);
}

void device_tree(const uint8_t* data, size_t size) {
  constexpr size_t kSizeField = 4;
  std::vector<uint8_t> blob(data, data + size);
  // A loader's memory goes on behind the blob: a header is always there, and so is what it claims.
  if (blob.size() < 40) blob.resize(40);
  const uint32_t magic = __builtin_bswap32(0xd00dfeedu);
  const auto claimed = __builtin_bswap32(static_cast<uint32_t>(blob.size()));
  std::memcpy(blob.data() + kSizeField, &claimed, sizeof claimed);
  bsp::DeviceTree out;
  (void)bsp::read_device_tree(blob.data(), out);
  std::memcpy(blob.data(), &magic, sizeof magic);
  (void)bsp::read_device_tree(blob.data(), out);
  PIRVS_ASSERT(std::memchr(out.arguments, 0, sizeof out.arguments) != nullptr);
  char value[8];
  for (const char* const word : {"cores", "semihosting", ""}) {
    if (!bsp::find_argument(out.arguments, word, value, sizeof value)) continue;
    PIRVS_ASSERT(std::memchr(value, 0, sizeof value) != nullptr);
  }
}

// The same bytes as a device's calibration and as its configuration: a fault names a line of the
// text, and what was set is text with an end.
void device_text(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
  const auto check = [lines](const ConfigFault& fault) {
    PIRVS_ASSERT(fault.line >= 0 && fault.line <= lines);
    Text<512> line;
    if (fault) put_fault(line, "device.cfg", fault);
  };
  Calibration calibration;
  const ConfigFault fault = read_calibration(text, calibration);
  check(fault);
  if (!fault) (void)find_fault(calibration);
  static board::Settings settings;
  settings = board::Settings{};
  check(board::read_settings(text, settings));
  check(board::find_missing(settings));
  for (const auto& set : {settings.calibration, settings.camera[0], settings.imu}) {
    PIRVS_ASSERT(std::memchr(set.text, 0, sizeof set.text) != nullptr);
  }
}

// What is typed at a serial line: each line is a request or has a reason, and names are text with
// an end.
void typed_text(const uint8_t* data, size_t size) {
  board::LineReader reader;
  for (size_t i = 0; i < size; ++i) {
    if (reader.take(static_cast<char>(data[i])) != board::LineReader::Taken::kLine) continue;
    const board::TextRequest request = board::read_request(reader.line());
    PIRVS_ASSERT((request.kind == board::RequestKind::kBad) == (request.why != nullptr));
    PIRVS_ASSERT(std::memchr(request.command.text, 0, Command::kTextMax) != nullptr);
  }
}

// Guessing checksums would keep the fuzzer busy for ever: kind, size and payload make a frame.
std::vector<uint8_t> right_frames(const uint8_t* data, size_t size) {
  using namespace pirvs::mavlink;
  constexpr MessageKind kKinds[] = {Heartbeat::kKind,  GpsRawInt::kKind, CommandLong::kKind,
                                    Timesync::kKind,   GpsInput::kKind,  WheelDistance::kKind,
                                    StatusText::kKind, {30, 39, 28}};
  std::vector<uint8_t> out;
  Sender sender;
  for (size_t at = 0; at + 2 < size;) {
    MessageKind kind = kKinds[data[at] % std::size(kKinds)];
    const size_t from = at + 2;
    kind.size = static_cast<uint8_t>(std::min<size_t>(data[at + 1], size - from));
    uint8_t payload[kPayloadMax] = {}, frame[kFrameMax];
    std::memcpy(payload, data + from, kind.size);
    const size_t bytes = write_frame(kind, payload, sender, frame);
    out.insert(out.end(), frame, frame + bytes);
    at = from + kind.size;
  }
  return out;
}

// What an autopilot's line brings: the first byte says in which pieces, and whether as it is or in
// frames whose checksums are right. Whatever comes, what goes on to the door is finite, and what
// goes out are whole frames.
void mavlink(const uint8_t* data, size_t size) {
  if (size == 0) return;
  static Link link;
  static TimeNs now;
  now = 1'000'000'000;
  static mavlink::FrameParser out;
  out.clear();
  LinkStack stack;
  stack.command = [](void*, const Command& command) -> Result<uint32_t> {
    PIRVS_ASSERT(command.kind == CommandKind::kReset || command.kind == CommandKind::kSetPose);
    return 0;
  };
  stack.deliver = [](void*, const Arrival& arrival) {
    const GnssFix& fix = arrival.gnss;
    const WheelSample& wheel = arrival.wheel;
    PIRVS_ASSERT(fix.t <= now && wheel.t <= now && fix.v_ned.allFinite());
    PIRVS_ASSERT(std::isfinite(fix.latitude_deg + fix.longitude_deg + fix.height_m));
    PIRVS_ASSERT(std::isfinite(fix.sigma_horizontal_m + fix.sigma_vertical_m));
    PIRVS_ASSERT(std::isfinite(wheel.value[0]) && std::isfinite(wheel.value[1]));
    return arrival.kind == ArrivalKind::kGnss ? Status::kOk : Status::kFull;
  };
  const auto send = [](void*, const uint8_t* bytes, size_t count) {
    mavlink::Frame frame;
    PIRVS_ASSERT(out.push(bytes, count) == count && out.next(frame) && !out.next(frame));
    return true;
  };
  link.configure(LinkSetup{}, ImuNoise{}, stack, {nullptr, send});
  Pose pose;
  pose.health = HealthState::kTracking;
  link.pose(pose);
  const size_t piece = size_t{data[0]} / 2 + 1;
  std::vector<uint8_t> bytes(data + 1, data + size);
  if (data[0] % 2 == 1) bytes = right_frames(data + 1, size - 1);
  for (size_t at = 0; at < bytes.size(); at += piece, now += 20'000'000) {
    link.receive(now, bytes.data() + at, std::min(piece, bytes.size() - at));
    link.poll(now);
    link.answer({0, CommandKind::kReset, Status::kStale});
  }
}

// Whatever a receiver sends: every fix has numbers, and every byte is in a frame or counted.
void expect_numbers(const ReceiverFix& read) {
  const GnssFix& fix = read.fix;
  PIRVS_ASSERT(fix.type <= GnssFixType::kFixed);
  if (fix.type == GnssFixType::kNone) return;
  PIRVS_ASSERT(std::isfinite(fix.latitude_deg) && std::isfinite(fix.longitude_deg));
  PIRVS_ASSERT(std::isfinite(fix.height_m) && fix.v_ned.head<2>().allFinite());
  PIRVS_ASSERT(fix.sigma_horizontal_m >= 0 && fix.sigma_vertical_m >= 0);
}

void ubx(const uint8_t* data, size_t size) {
  const auto reader = std::make_unique<UbxReader>();
  ReceiverFix fix;
  for (size_t i = 0; i < size; ++i) {
    if (reader->take(data[i], fix)) expect_numbers(fix);
  }
  while (reader->flush(fix)) expect_numbers(fix);
  PIRVS_ASSERT(reader->counters().bytes_outside <= size);
  PIRVS_ASSERT(size >= reader->counters().bytes_outside + size_t{8} * reader->counters().frames);
}

void nmea(const uint8_t* data, size_t size) {
  NmeaReader reader;
  ReceiverFix fix;
  for (size_t i = 0; i < size; ++i) {
    if (reader.take(data[i], fix)) expect_numbers(fix);
  }
  while (reader.flush(fix)) expect_numbers(fix);
  PIRVS_ASSERT(reader.counters().bytes_outside <= size);
}

// Guessing checksums would keep the fuzzer busy for ever.
void make_checksums_right(std::vector<uint8_t>& bytes) {
  constexpr size_t kHead = 6, kTail = 2;
  for (size_t at = 0; at + kHead + kTail <= bytes.size(); ++at) {
    if (bytes[at] != 0xb5 || bytes[at + 1] != 0x62) continue;
    const size_t end = at + kHead + bytes[at + 4] + (size_t{bytes[at + 5]} << 8);
    if (end + kTail > bytes.size()) continue;
    uint8_t a = 0, b = 0;
    for (size_t i = at + 2; i < end; ++i) {
      a = uint8_t(a + bytes[i]);
      b = uint8_t(b + a);
    }
    bytes[end] = a;
    bytes[end + 1] = b;
    at = end + kTail - 1;
  }
}

// Both languages at once, and the clock: what a device hears of a receiver.
void receiver(const uint8_t* data, size_t size) {
  std::vector<uint8_t> bytes(data, data + size);
  make_checksums_right(bytes);
  const auto reader = std::make_unique<ReceiverReader>();
  ReceiverClock clock;
  clock.configure(ReceiverClock::kLatency_ns);
  ReceiverFix fix;
  TimeNs now = 1'000'000'000;
  for (const uint8_t byte : bytes) {
    now += 87'000;
    if (byte == 0xff) clock.pulse({now / 1'000'000'000 * 1'000'000'000, 20e3, 700});
    if (!reader->take(byte, fix)) continue;
    expect_numbers(fix);
    ReceiverStamp stamp = clock.stamp_without_time(now);
    if (fix.has_time && !fix.overdue) (void)clock.stamp(fix.t_utc, now, stamp);
    if (fix.has_time && fix.overdue) (void)clock.stamp(fix.t_utc, stamp);
    PIRVS_ASSERT(std::isfinite(stamp.sigma_ns) && stamp.sigma_ns > 0);
  }
}

void gnss_table(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  for (const auto format : {tools::GnssFormat::kTable, tools::GnssFormat::kRtklib}) {
    expect_result_or_refusal([&] {
      tools::InputLog log;
      const auto fixes = tools::read_gnss(file.path(), format, log);
      for (size_t i = 0; i < fixes.size(); ++i) {
        expect_numbers({fixes[i], false, 0, false});
        PIRVS_ASSERT(i == 0 || fixes[i].t > fixes[i - 1].t);
      }
    });
  }
  expect_result_or_refusal([&] { (void)tools::read_gnss_sensor(file.path()); });
}

}  // namespace

const Target kTargets[] = {
    {"imu_csv", imu_csv},
    {"image_list", image_list},
    {"loose_table", loose_table},
    {"order_csv", order_csv},
    {"sensor_yaml", sensor_yaml},
    {"rig_file", rig_file},
    {"realsense", realsense},
    {"camera_info", camera_info},
    {"log", log},
    {"trajectory", trajectory},
    {"parameter", parameter},
    {"fault", fault},
    {"pack", pack},
    {"device_tree", device_tree},
    {"device_text", device_text},
    {"typed_text", typed_text},
    {"mavlink", mavlink},
    {"ubx", ubx},
    {"nmea", nmea},
    {"receiver", receiver},
    {"gnss_table", gnss_table},
};
const size_t kTargetCount = std::size(kTargets);

const Target* find_target(const char* name) {
  for (const Target& target : kTargets) {
    if (std::strcmp(name, target.name) == 0) return &target;
  }
  return nullptr;
}

}  // namespace pirvs::fuzz
