#include "bsp/replay/pack.h"

#include <cstring>

#include "core/base/assert.h"

namespace pirvs::bsp {
namespace {

constexpr int kSideMax = 1 << 14;  // of an image: keeps every product below 2^63

uint64_t mixed(const uint8_t* begin, const uint8_t* end, uint64_t sum) {
  for (; begin < end; begin += 8) {
    uint64_t word;
    std::memcpy(&word, begin, sizeof word);
    sum = (sum ^ word) * 0x9e3779b97f4a7c15u;  // odd, so that no word is lost
    sum ^= sum >> 32;
  }
  return sum;
}

}  // namespace

uint64_t pack_checksum(const void* bytes, size_t size) {
  PIRVS_ASSERT(size % 8 == 0 && size >= sizeof(PackHeader));
  constexpr size_t kField = offsetof(PackHeader, checksum);
  const uint8_t* const begin = static_cast<const uint8_t*>(bytes);
  const uint64_t sum = mixed(begin, begin + kField, 0);
  return mixed(begin + kField + sizeof(uint64_t), begin + size, sum);
}

Status Pack::open(const void* bytes, size_t size) {
  *this = Pack{};
  if (size < sizeof(PackHeader)) return Status::kNotFound;
  PIRVS_ASSERT(reinterpret_cast<uintptr_t>(bytes) % kPackAlign == 0);
  const PackHeader& header = *static_cast<const PackHeader*>(bytes);
  if (std::memcmp(header.magic, kPackMagic, sizeof kPackMagic) != 0) return Status::kNotFound;
  if (header.version != kPackVersion || header.header_bytes != sizeof header) return Status::kStale;
  // A loader may round the size up to whole pages.
  if (header.bytes > size || header.bytes % 8 != 0) return Status::kBadData;
  const uint64_t tables = sizeof header + header.imu_count * sizeof(PackedSample) +
                          header.frame_count * sizeof(PackedFrame) +
                          header.fix_count * sizeof(PackedFix);
  if (tables > header.bytes) return Status::kBadData;
  bytes_ = static_cast<const uint8_t*>(bytes);
  header_ = &header;
  samples_ = reinterpret_cast<const PackedSample*>(bytes_ + sizeof header);
  frames_ = reinterpret_cast<const PackedFrame*>(samples_ + header.imu_count);
  fixes_ = reinterpret_cast<const PackedFix*>(frames_ + header.frame_count);
  const Status status = check();
  if (status != Status::kOk) *this = Pack{};
  return status;
}

Status Pack::check() const {
  for (const PackedCamera& camera : header_->camera) {
    if (camera.model > 1 || camera.width <= 0 || camera.height <= 0) return Status::kBadData;
    if (camera.width > kSideMax || camera.height > kSideMax) return Status::kBadData;
  }
  for (uint32_t i = 0; i < header_->frame_count; ++i) {
    for (int c = 0; c < kCamerasMax; ++c) {
      const uint64_t offset = frames_[i].image[c];
      if (offset != 0 && !image_fits(offset, header_->camera[c])) return Status::kBadData;
    }
  }
  for (uint32_t i = 0; i < header_->fix_count; ++i) {
    if (fixes_[i].type >= kFixTypes) return Status::kBadData;
  }
  const bool whole = pack_checksum(bytes_, header_->bytes) == header_->checksum;
  return whole ? Status::kOk : Status::kBadData;
}

bool Pack::image_fits(uint64_t offset, const PackedCamera& camera) const {
  const uint64_t pixels =
      static_cast<uint64_t>(camera.width) * static_cast<uint64_t>(camera.height);
  return offset % kPackAlign == 0 && offset <= header_->bytes && pixels <= header_->bytes - offset;
}

Camera Pack::camera(int c) const {
  const PackedCamera& packed = header_->camera[c];
  Camera out;
  out.model = static_cast<CameraModel>(packed.model);
  out.width = packed.width;
  out.height = packed.height;
  out.fx = packed.fx;
  out.fy = packed.fy;
  out.cx = packed.cx;
  out.cy = packed.cy;
  std::memcpy(out.d, packed.d, sizeof out.d);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) out.T_BC.R(i, k) = packed.R_BC[3 * i + k];
    out.T_BC.p(i) = packed.p_BC[i];
  }
  return out;
}

ImuSample Pack::imu(size_t i) const {
  const PackedSample& sample = samples_[i];
  return {sample.t, Vec3(sample.w_B[0], sample.w_B[1], sample.w_B[2]),
          Vec3(sample.f_B[0], sample.f_B[1], sample.f_B[2])};
}

StereoFrame Pack::frame(size_t i) const {
  StereoFrame out;
  out.t = frames_[i].t;
  for (int c = 0; c < kCamerasMax; ++c) {
    if (frames_[i].image[c] == 0) continue;
    const PackedCamera& camera = header_->camera[c];
    out.image[c] = {bytes_ + frames_[i].image[c], camera.width, camera.height, camera.width};
    out.info[c].sequence = static_cast<uint32_t>(i);
    out.present = static_cast<uint8_t>(out.present | 1u << c);
  }
  return out;
}

RecordingSource Pack::source() {
  PIRVS_ASSERT(header_ != nullptr);
  imu_at_ = frame_at_ = fix_at_ = 0;
  return {this, next_imu, next_frame, [](void*, FrameId) {}};
}

bool Pack::next_imu(void* context, ImuSample& out) {
  Pack& pack = *static_cast<Pack*>(context);
  if (pack.imu_at_ == pack.header_->imu_count) return false;
  out = pack.imu(pack.imu_at_++);
  return true;
}

bool Pack::next_fix(PackedFix& out) {
  if (fix_at_ == header_->fix_count || imu_at_ == 0) return false;
  const int64_t comes = fixes_[fix_at_].t + header_->gnss_time_offset_ns + header_->gnss_latency_ns;
  if (samples_[imu_at_ - 1].t < comes) return false;
  out = fixes_[fix_at_++];
  return true;
}

bool Pack::next_frame(void* context, StereoFrame& out) {
  Pack& pack = *static_cast<Pack*>(context);
  if (pack.frame_at_ == pack.header_->frame_count) return false;
  out = pack.frame(pack.frame_at_++);
  return true;
}

}  // namespace pirvs::bsp
