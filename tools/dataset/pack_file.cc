#include "tools/dataset/pack_file.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "board/bare/pack_input.h"
#include "bsp/replay/pack.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/player.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

// A block of memory whose begin is aligned as a pack wants it.
struct Block {
  std::vector<uint64_t> words;
  size_t bytes = 0;

  explicit Block(size_t size) : words((size + bsp::kPackAlign) / 8 + 1), bytes(size) {}
  uint8_t* data() {
    const auto begin = reinterpret_cast<uintptr_t>(words.data());
    const uintptr_t aligned = (begin + bsp::kPackAlign - 1) / bsp::kPackAlign * bsp::kPackAlign;
    return reinterpret_cast<uint8_t*>(aligned);
  }
};

size_t aligned(size_t bytes) {
  return (bytes + bsp::kPackAlign - 1) / bsp::kPackAlign * bsp::kPackAlign;
}

bsp::PackedCamera packed(const Camera& camera) {
  bsp::PackedCamera out{};
  out.model = static_cast<uint32_t>(camera.model);
  out.width = camera.width;
  out.height = camera.height;
  out.fx = camera.fx;
  out.fy = camera.fy;
  out.cx = camera.cx;
  out.cy = camera.cy;
  std::copy_n(camera.d, 4, out.d);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) out.R_BC[3 * i + k] = camera.T_BC.R(i, k);
    out.p_BC[i] = camera.T_BC.p(i);
  }
  return out;
}

bsp::PackHeader header_of(const Recording& recording) {
  const ImuNoise& noise = recording.calibration.imu;
  bsp::PackHeader out{};
  std::memcpy(out.magic, bsp::kPackMagic, sizeof out.magic);
  out.version = bsp::kPackVersion;
  out.header_bytes = sizeof out;
  out.imu_count = uint32_t(recording.imu.size());
  out.frame_count = uint32_t(recording.frames.size());
  out.camera_time_offset_ns = recording.calibration.camera_time_offset_ns;
  out.gyro_noise = noise.gyro_noise;
  out.gyro_walk = noise.gyro_walk;
  out.accel_noise = noise.accel_noise;
  out.accel_walk = noise.accel_walk;
  out.rate_hz = noise.rate_hz;
  for (int c = 0; c < 2; ++c) out.camera[c] = packed(recording.calibration.camera[c]);
  const GnssAntenna& antenna = recording.calibration.gnss;
  out.fix_count = uint32_t(recording.gnss.size());
  for (int i = 0; i < 3; ++i) out.antenna[i] = antenna.p_BA[i];
  out.gnss_time_offset_ns = antenna.time_offset_ns;
  out.gnss_latency_ns = recording.gnss_sensor.latency_ns;
  return out;
}

void put_samples(const Recording& recording, uint8_t* to) {
  // A pack has no place for them: its samples are what the door would make of the recording's.
  ImuCorrection correction;
  correction.configure(recording.calibration.imu_intrinsics);
  for (ImuSample sample : recording.imu) {
    correction.apply(sample);
    const bsp::PackedSample out = {sample.t,
                                   {sample.w_B.x(), sample.w_B.y(), sample.w_B.z()},
                                   {sample.f_B.x(), sample.f_B.y(), sample.f_B.z()}};
    std::memcpy(to, &out, sizeof out);
    to += sizeof out;
  }
}

void put_fixes(const Recording& recording, uint8_t* to) {
  for (const GnssFix& fix : recording.gnss) {
    const bsp::PackedFix out = {fix.t,
                                fix.latitude_deg,
                                fix.longitude_deg,
                                fix.height_m,
                                {fix.v_ned.x(), fix.v_ned.y(), fix.v_ned.z()},
                                fix.sigma_horizontal_m,
                                fix.sigma_vertical_m,
                                fix.sigma_velocity_m_s,
                                uint32_t(fix.type),
                                fix.has_velocity};
    std::memcpy(to, &out, sizeof out);
    to += sizeof out;
  }
}

}  // namespace

size_t write_pack(const Recording& recording, const std::string& path,
                  const std::function<void(size_t, size_t)>& on_frame) {
  if (recording.calibration.cameras != 2) {
    throw InputError("only one camera", recording.folder, "a pack holds a stereo pair");
  }
  bsp::PackHeader header = header_of(recording);
  const size_t samples_at = sizeof header;
  const size_t frames_at = samples_at + header.imu_count * sizeof(bsp::PackedSample);
  const size_t fixes_at = frames_at + header.frame_count * sizeof(bsp::PackedFrame);
  const size_t images_at = aligned(fixes_at + header.fix_count * sizeof(bsp::PackedFix));
  size_t image_bytes[2];
  for (int c = 0; c < 2; ++c) {
    const Camera& camera = recording.calibration.camera[c];
    image_bytes[c] = aligned(size_t(camera.width) * size_t(camera.height));
  }
  Block block(images_at + header.frame_count * (image_bytes[0] + image_bytes[1]));
  put_samples(recording, block.data() + samples_at);
  put_fixes(recording, block.data() + fixes_at);
  size_t at = images_at;
  Player player(recording);
  for (size_t i = 0; const StereoFrame* frame = player.next(); player.release(frame), ++i) {
    bsp::PackedFrame row = {frame->t, {0, 0}};
    for (int c = 0; c < 2; ++c) {
      const ImageView& image = frame->image[c];
      if (image.data == nullptr) continue;
      row.image[c] = at;
      for (int y = 0; y < image.height; ++y) {
        std::memcpy(block.data() + at + size_t(y) * size_t(image.width), image.row(y),
                    size_t(image.width));
      }
      at += image_bytes[c];
    }
    std::memcpy(block.data() + frames_at + i * sizeof row, &row, sizeof row);
    on_frame(i + 1, header.frame_count);
  }
  header.bytes = at;
  std::memcpy(block.data(), &header, sizeof header);
  header.checksum = bsp::pack_checksum(block.data(), at);
  std::memcpy(block.data(), &header, sizeof header);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(block.data()), std::streamsize(at));
  file.close();
  if (!file) {
    std::error_code error;
    if (fs::is_regular_file(path, error)) fs::remove(path, error);
    throw InputError("cannot write", path, "check space and permissions");
  }
  return at;
}

Recording open_pack(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  const size_t size = size_t(fs::file_size(path, error));
  if (!file || error) throw InputError("cannot read", path, "check the path and its permissions");
  const auto block = std::make_shared<Block>(size);
  file.read(reinterpret_cast<char*>(block->data()), std::streamsize(size));
  if (size_t(file.gcount()) != size) throw InputError("cannot read", path, "check the disk");
  bsp::Pack pack;
  switch (pack.open(block->data(), size)) {
    case Status::kOk:
      break;
    case Status::kNotFound:
      throw InputError("not a packed recording", path, "write one with pirvs pack");
    case Status::kStale:
      throw InputError("packed by another version", path, "pack the recording again");
    default:
      throw InputError("the pack is cut off or damaged", path, "pack the recording again");
  }
  const bsp::PackHeader& header = pack.header();
  if (header.imu_count == 0 || header.frame_count == 0) {
    throw InputError("no images or no IMU samples", path, "pack a recording that has both");
  }
  Recording recording;
  recording.folder = path;
  recording.pack = block;
  recording.calibration = board::calibration_of(pack);
  recording.gnss_sensor.antenna = recording.calibration.gnss;
  recording.gnss_sensor.latency_ns = header.gnss_latency_ns;
  for (size_t i = 0; i < header.fix_count; ++i) {
    recording.gnss.push_back(board::fix_of(pack.fix(i)));
  }
  recording.gnss_apart = true;
  for (size_t i = 0; i < header.imu_count; ++i) recording.imu.push_back(pack.imu(i));
  for (size_t i = 0; i < header.frame_count; ++i) {
    const StereoFrame frame = pack.frame(i);
    FrameFiles row;
    row.t = frame.t;
    for (int c = 0; c < 2; ++c) row.pixels[c] = frame.image[c];
    recording.frames.push_back(row);
  }
  return recording;
}

}  // namespace pirvs::tools
