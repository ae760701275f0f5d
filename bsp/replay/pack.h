// A recording packed into one block of bytes: what a boot loader puts in RAM, and what tools/pack
// writes. The sensors of bsp/replay can be fed from it without a copy.
// In      A block of memory, 64-byte aligned, that stays as it is while the recording plays.
// Out     open(): calibration and counts; source(): for Replay::start. Layout PackHeader; imu_count
//         PackedSample; frame_count PackedFrame; fix_count PackedFix; then the images as they are,
//         8-bit grey, rows without gaps, each at a multiple of 64. Little endian. The checksum
//         covers everything but itself. next_fix(): GNSS, each at its turn.
// Frames  B = the IMU; R_BC row by row, p_BC in m; t in ns, each sensor's own stamps.
// Errors  kNotFound: no magic, so no recording. kStale: another version. kBadData: shorter than it
//         says, a count or an offset beyond the end, a wrong checksum, images of size zero.
// Cost    open() reads every byte once, ~1 ns a byte on an A53.
// Source  DESIGN, "board/qemu-virt": sensors from a recording that the boot loader puts in RAM.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/replay/replay.h"
#include "core/base/status.h"
#include "core/camera/camera.h"

namespace pirvs::bsp {

inline constexpr char kPackMagic[8] = {'P', 'I', 'R', 'V', 'S', 'P', 'C', 'K'};
inline constexpr uint32_t kPackVersion = 2;
inline constexpr size_t kPackAlign = 64;

struct PackedCamera {
  uint32_t model;  // CameraModel
  int32_t width, height;
  uint32_t reserved;
  double fx, fy, cx, cy;
  double d[4];
  double R_BC[9];
  double p_BC[3];
};

struct PackHeader {
  char magic[8];
  uint32_t version;
  uint32_t header_bytes;
  uint64_t bytes;  // of the whole pack
  uint64_t checksum;
  uint32_t imu_count;
  uint32_t frame_count;
  int64_t camera_time_offset_ns;
  double gyro_noise, gyro_walk, accel_noise, accel_walk, rate_hz;
  PackedCamera camera[kCamerasMax];
  uint32_t fix_count;
  uint32_t reserved;
  double antenna[3];  // of GNSS, in B
  int64_t gnss_time_offset_ns;
  int64_t gnss_latency_ns;  // from a fix's stamp, put right, to its arrival
};

struct PackedSample {
  int64_t t;
  double w_B[3];
  double f_B[3];
};

struct PackedFrame {
  int64_t t;
  uint64_t
      image[kCamerasMax];  // offset from the start of the pack; 0: that camera has no image at t
};

// A fix of GNSS, as modules/door/items.h has it.
struct PackedFix {
  int64_t t;
  double latitude_deg, longitude_deg, height_m;
  double v_ned[3];
  double sigma_horizontal_m, sigma_vertical_m, sigma_velocity_m_s;
  uint32_t type;
  uint32_t has_velocity;
};
inline constexpr uint32_t kFixTypes = 5;

static_assert(sizeof(PackedCamera) == 176 && sizeof(PackHeader) == 488, "no gaps, on any machine");
static_assert(sizeof(PackedSample) == 56 && sizeof(PackedFrame) == 24 && sizeof(PackedFix) == 88);

// Of a whole pack, its own field left out; size is a multiple of 8.
uint64_t pack_checksum(const void* bytes, size_t size);

class Pack {
 public:
  Status open(const void* bytes, size_t size);
  RecordingSource source();  // from the first item on; the pack must outlive the replay

  const PackHeader& header() const { return *header_; }
  Camera camera(int c) const;
  StereoFrame frame(size_t i) const;
  ImuSample imu(size_t i) const;
  const PackedFix& fix(size_t i) const { return fixes_[i]; }
  // The next fix, once the samples that source() gave have come to its time.
  bool next_fix(PackedFix& out);

 private:
  static bool next_imu(void* context, ImuSample& out);
  static bool next_frame(void* context, StereoFrame& out);
  Status check() const;
  bool image_fits(uint64_t offset, const PackedCamera& camera) const;

  const uint8_t* bytes_ = nullptr;
  const PackHeader* header_ = nullptr;
  const PackedSample* samples_ = nullptr;
  const PackedFrame* frames_ = nullptr;
  const PackedFix* fixes_ = nullptr;
  size_t imu_at_ = 0, frame_at_ = 0, fix_at_ = 0;
};

}  // namespace pirvs::bsp
