#include "board/library/fed_sensors.h"

#include <atomic>
#include <cstring>
#include <new>
#include <utility>

#include "bsp/api/clock.h"
#include "bsp/api/tick.h"
#include "core/store/lending.h"
#include "core/store/ring.h"

namespace pirvs {
namespace {

constexpr int kFrames = bsp::kFramesLentMax + board::kFramesWaiting;

struct Sample {
  ImuSample imu;
  bool after_loss = false;
};

struct {
  int width = 0, height = 0;
  bool by_the_clock = false;
  std::atomic<bool> ended{false};
  TimeNs next_tick = 0;
  // The feeder's.
  bool imu_lost = false;
  uint32_t frames_lost = 0;
  // From the feeder to the door's core.
  Ring<Sample, board::kImuWaiting> samples;
  Ring<StereoFrame, board::kFramesWaiting> frames;
  Lending<StereoFrame, kFrames> lending;
} fed;

uint8_t pixels[kFrames][kCamerasMax][kImagePixelsMax];

ImageView copy(const board::FedImages& from, int camera, int slot) {
  uint8_t* const to = pixels[slot][camera];
  const auto width = static_cast<size_t>(fed.width);
  for (int y = 0; y < fed.height; ++y) {
    std::memcpy(to + width * static_cast<size_t>(y),
                from.image[camera] + static_cast<ptrdiff_t>(from.stride) * y, width);
  }
  return {to, fed.width, fed.height, fed.width};
}

// What was added before the end is polled first.
template <class Items>
Status nothing(Items& items) {
  const bool ended = fed.ended.load(std::memory_order_acquire);
  return ended && items.front() == nullptr ? Status::kStale : Status::kEmpty;
}

}  // namespace

void board::open_fed_sensors(int width, int height, bool by_the_clock) {
  using Fed = decltype(fed);
  fed.~Fed();
  new (&fed) Fed;
  fed.width = width;
  fed.height = height;
  fed.by_the_clock = by_the_clock;
}

Status board::add(const ImuSample& sample) {
  Sample* const slot = fed.samples.begin_push();
  if (slot == nullptr) {
    fed.imu_lost = true;
    return Status::kFull;
  }
  *slot = {sample, std::exchange(fed.imu_lost, false)};
  fed.samples.end_push();
  return Status::kOk;
}

Status board::add(const FedImages& images) {
  StereoFrame* const slot = fed.frames.begin_push();
  const Result<FrameId> id = slot != nullptr ? fed.lending.lend() : Status::kFull;
  if (!id.ok()) {
    ++fed.frames_lost;
    return Status::kFull;
  }
  *slot = StereoFrame{};
  slot->t = images.t;
  slot->id = id.value();
  for (int c = 0; c < kCamerasMax; ++c) {
    if (images.image[c] == nullptr) continue;
    slot->image[c] = copy(images, c, id.value().slot);
    slot->present = static_cast<uint8_t>(slot->present | 1u << c);
  }
  slot->lost_before = std::exchange(fed.frames_lost, 0);
  fed.frames.end_push();
  return Status::kOk;
}

void board::end_fed_sensors() { fed.ended.store(true, std::memory_order_release); }

namespace bsp {

Status imu_poll(ImuSample& out) {
  const Sample* const sample = fed.samples.front();
  if (sample == nullptr) return nothing(fed.samples);
  out = sample->imu;
  const Status status = sample->after_loss ? Status::kFull : Status::kOk;
  fed.samples.pop();
  return status;
}

Status imu_temperature(float&) { return Status::kNotFound; }

Status camera_poll(StereoFrame& out) {
  const StereoFrame* const frame = fed.frames.front();
  if (frame == nullptr) return nothing(fed.frames);
  out = *frame;
  fed.frames.pop();
  return Status::kOk;
}

void camera_retain(FrameId id) { fed.lending.retain(id); }

void camera_release(FrameId id) {
  if (fed.lending.release(id)) fed.lending.recycle(id);
}

Result<CameraRange> camera_range() { return Status::kNotFound; }

Status camera_control(const CameraControl&) { return Status::kNotFound; }

Status tick_poll(TimeNs& out) {
  const TimeNs t = now();
  if (!fed.by_the_clock || t < fed.next_tick) return Status::kEmpty;
  out = t;
  fed.next_tick = t + kTick_ns;
  return Status::kOk;
}

}  // namespace bsp
}  // namespace pirvs
