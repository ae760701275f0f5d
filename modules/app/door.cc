#include "modules/app/door.h"

#include <iterator>

namespace pirvs {
namespace {

// Beyond what any IMU that we might carry measures (4000 deg/s, 32 g): a broken transfer.
constexpr double kRate_rad_s_max = 75.0;
constexpr double kForce_m_s2_max = 320.0;
constexpr TimeNs kImuGap_ns = 50'000'000;  // ten samples at 200 Hz: reported, then bridged

ImuSample between(const ImuSample& a, const ImuSample& b, TimeNs t) {
  const double s = to_seconds(t - a.t) / to_seconds(b.t - a.t);
  ImuSample out;
  out.t = t;
  out.w_B = a.w_B + s * (b.w_B - a.w_B);
  out.f_B = a.f_B + s * (b.f_B - a.f_B);
  return out;
}

}  // namespace

const char* name(DoorLoss loss) {
  static constexpr const char* kNames[] = {
      "imu_not_finite",  "imu_out_of_range", "imu_backwards",     "imu_lost",      "imu_gap",
      "frame_backwards", "frame_before_imu", "frame_without_imu", "camera_missing"};
  static_assert(std::size(kNames) == static_cast<size_t>(DoorLoss::kCount));
  return kNames[static_cast<size_t>(loss)];
}

void Door::configure(TimeNs camera_time_offset) {
  *this = Door{};
  offset_ = camera_time_offset;
}

bool Door::fetch_imu() {
  while (!has_ahead_ && !imu_ended_) {
    const Status status = bsp::imu_poll(ahead_);
    if (status == Status::kStale) imu_ended_ = true;
    if (status == Status::kFull) count(DoorLoss::kImuLost);  // this sample is good
    if (status != Status::kOk && status != Status::kFull) return false;
    if (!ahead_.w_B.allFinite() || !ahead_.f_B.allFinite()) {
      count(DoorLoss::kImuNotFinite);
    } else if (ahead_.w_B.cwiseAbs().maxCoeff() > kRate_rad_s_max ||
               ahead_.f_B.cwiseAbs().maxCoeff() > kForce_m_s2_max) {
      count(DoorLoss::kImuOutOfRange);
    } else if (has_last_ && ahead_.t <= last_.t) {
      count(DoorLoss::kImuBackwards);
    } else {
      if (has_last_ && ahead_.t - last_.t > kImuGap_ns) count(DoorLoss::kImuGap);
      has_ahead_ = true;
    }
  }
  return has_ahead_;
}

bool Door::fetch_frame() {
  while (!has_frame_ && !frames_ended_) {
    const Status status = bsp::camera_poll(frame_.images);
    if (status == Status::kStale) frames_ended_ = true;
    if (status != Status::kOk) return false;
    frame_.t = frame_.images.t + offset_;
    has_frame_ = true;
    if (frame_.t <= last_frame_t_) {
      drop_frame(DoorLoss::kFrameBackwards);
    } else if (frame_.images.present == 0) {
      drop_frame(DoorLoss::kCameraMissing);
    } else if (frame_.images.present != 3) {
      count(DoorLoss::kCameraMissing);
    }
  }
  return has_frame_;
}

void Door::drop_frame(DoorLoss why) {
  count(why);
  bsp::camera_release();
  has_frame_ = false;
}

Status Door::next(DoorItem& out) {
  for (;;) {
    const bool frame = fetch_frame();
    const bool imu = fetch_imu();
    if (frame && has_last_ && frame_.t < last_.t) {
      drop_frame(DoorLoss::kFrameBeforeImu);
      continue;
    }
    if (frame && has_last_ && frame_.t == last_.t) {
      out.is_frame = true;
      out.frame = frame_;
      last_frame_t_ = frame_.t;
      return Status::kOk;
    }
    if (frame && imu && !has_last_ && frame_.t < ahead_.t) {
      drop_frame(DoorLoss::kFrameBeforeImu);
      continue;
    }
    if (!imu) {
      if (!imu_ended_) return Status::kEmpty;
      if (frame) {
        drop_frame(DoorLoss::kFrameWithoutImu);
        continue;
      }
      return frames_ended_ ? Status::kStale : Status::kEmpty;
    }
    // Without a frame in sight the IMU must wait, or the frame's own sample could not be made.
    if (!frame && !frames_ended_) return Status::kEmpty;
    const bool cut = frame && ahead_.t > frame_.t && has_last_;
    out.is_frame = false;
    out.imu = cut ? between(last_, ahead_, frame_.t) : ahead_;
    has_ahead_ = cut;
    last_ = out.imu;
    has_last_ = true;
    return Status::kOk;
  }
}

void Door::release() {
  bsp::camera_release();
  has_frame_ = false;
}

}  // namespace pirvs
