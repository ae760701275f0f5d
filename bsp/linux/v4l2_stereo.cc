#include "bsp/linux/v4l2_stereo.h"

#include <algorithm>

#include "bsp/api/clock.h"
#include "bsp/api/events.h"

namespace pirvs::bsp {
namespace {

constexpr uint8_t kLeft = 1, kRight = 2, kBoth = 3;

TimeNs distance(TimeNs a, TimeNs b) { return a < b ? b - a : a - b; }

// Counts wrap around.
int32_t difference(uint32_t a, uint32_t b) { return static_cast<int32_t>(a - b); }

}  // namespace

void V4l2Stereo::configure(const V4l2StereoSetup& setup, const DeviceNews& news,
                           const SystemCalls& calls) {
  setup_ = setup;
  for (int c = 0; c < setup_.cameras; ++c) nodes_[c].configure(setup_.camera[c], news, calls);
}

// Whoever still holds an image keeps it.
void V4l2Stereo::close() {
  for (int c = 0; c < setup_.cameras; ++c) {
    drop(c);
    nodes_[c].close();
  }
}

// What every camera that is there can do.
Result<CameraRange> V4l2Stereo::range() const {
  CameraRange out;
  bool any = false;
  for (int c = 0; c < setup_.cameras; ++c) {
    if (!nodes_[c].is_open()) continue;
    if (!nodes_[c].controls().takes_exposure()) return Status::kNotFound;
    const CameraRange one = nodes_[c].controls().range();
    if (!any) out = one;
    any = true;
    out.exposure_ns_min = std::max(out.exposure_ns_min, one.exposure_ns_min);
    out.exposure_ns_max = std::min(out.exposure_ns_max, one.exposure_ns_max);
    out.exposure_ns_step = std::max(out.exposure_ns_step, one.exposure_ns_step);
    out.gain_min = std::max(out.gain_min, one.gain_min);
    out.gain_max = std::min(out.gain_max, one.gain_max);
    out.gain_step = std::max(out.gain_step, one.gain_step);
  }
  return any ? Result<CameraRange>(out) : Status::kEmpty;
}

Status V4l2Stereo::control(const CameraControl& control) {
  const Result<CameraRange> possible = range();
  if (possible.status() == Status::kNotFound) return Status::kNotFound;
  if (possible.ok() && control.exposure_ns != 0) {
    const CameraRange& r = possible.value();
    const TimeNs e = control.exposure_ns;
    const float g = control.gain, rounding = 1e-3f * r.gain_max;
    const bool inside = e >= r.exposure_ns_min - r.exposure_ns_step &&
                        e <= r.exposure_ns_max + r.exposure_ns_step && g >= r.gain_min - rounding &&
                        g <= r.gain_max + rounding;
    if (!inside) return Status::kBadData;
  }
  for (int c = 0; c < setup_.cameras; ++c) nodes_[c].control(control);
  return Status::kOk;
}

void V4l2Stereo::release(FrameId id) {
  if (!lending_.release(id)) return;
  for (int c = 0; c < setup_.cameras; ++c) {
    if (lent_[id.slot][c] >= 0) nodes_[c].give_back(lent_[id.slot][c]);
  }
  lending_.recycle(id);
}

void V4l2Stereo::drop(int c) {
  if (heads_[c].here) nodes_[c].give_back(heads_[c].image.buffer);
  heads_[c].here = false;
}

// On the count of camera 0, once counts are known.
uint32_t V4l2Stereo::count_of(int c) const {
  return heads_[c].image.sequence + (c == 1 ? count_offset_ : 0);
}

bool V4l2Stereo::is_past(int c) const {
  const bool counted = setup_.cameras == 1 || counts_known_;
  return counted && has_last_ && difference(count_of(c), last_count_) <= 0;
}

// False: this camera has no image, nor will it have one soon.
bool V4l2Stereo::fetch(int c) {
  while (!heads_[c].here) {
    const Status status = nodes_[c].take(heads_[c].image);
    const uint32_t starts = nodes_[c].starts();
    if (starts != starts_[c]) {  // it counts anew
      starts_[c] = starts;
      counts_known_ = has_last_ = false;
    }
    if (status == Status::kBusFault) return false;
    if (status == Status::kEmpty) return true;
    heads_[c].here = true;
    if (setup_.pairing == Pairing::kStamp || !is_past(c)) return true;
    ++counters_.after_its_half;
    drop(c);
  }
  return true;
}

void V4l2Stereo::find_counts() {
  if (distance(heads_[0].image.t, heads_[1].image.t) > setup_.pair_ns_max) return;
  count_offset_ = heads_[0].image.sequence - heads_[1].image.sequence;
  counts_known_ = true;
  has_last_ = false;
  ++counters_.counts_found;
}

V4l2Stereo::Choice V4l2Stereo::choose_by_trigger() {
  const TimeNs t0 = heads_[0].image.t, t1 = heads_[1].image.t;
  const Choice older = t0 < t1 ? kLeft : kRight;
  if (counts_known_) {
    const int32_t ahead = difference(count_of(0), count_of(1));
    const bool together = distance(t0, t1) <= setup_.pair_ns_max;
    if (ahead == 0 && together) return kBoth;
    // The older count is the older image, or the counts are wrong.
    if (ahead < 0 && t0 < t1 && !together) return kLeft;
    if (ahead > 0 && t1 < t0 && !together) return kRight;
    ++counters_.counts_wrong;
    counts_known_ = has_last_ = false;
  }
  find_counts();
  return counts_known_ ? kBoth : older;
}

V4l2Stereo::Choice V4l2Stereo::choose_by_stamp() const {
  const TimeNs t0 = heads_[0].image.t, t1 = heads_[1].image.t;
  if (2 * distance(t0, t1) < setup_.period_ns) return kBoth;
  return t0 < t1 ? kLeft : kRight;
}

// One head is here: how long does it wait for its partner?
V4l2Stereo::Choice V4l2Stereo::alone() {
  const int c = heads_[0].here ? 0 : 1;
  const Choice choice = c == 0 ? kLeft : kRight;
  const V4l2Node& other = nodes_[1 - c];
  if (setup_.cameras == 1 || !other.is_open() || other.stalls()) return choice;
  const TimeNs until = heads_[c].image.arrival + setup_.partner_wait_ns;
  if (now() >= until) return choice;
  alarm(until);
  return 0;
}

V4l2Stereo::Choice V4l2Stereo::choose() {
  const bool both = heads_[0].here && heads_[1].here;
  if (!both) return heads_[0].here || heads_[1].here ? alone() : 0;
  return setup_.pairing == Pairing::kTrigger ? choose_by_trigger() : choose_by_stamp();
}

Status V4l2Stereo::lend(Choice choice, StereoFrame& out) {
  const Result<FrameId> id = lending_.lend();
  if (!id.ok()) return Status::kEmpty;  // what comes now is lost by the camera, and counted
  out = StereoFrame{};
  out.id = id.value();
  out.present = choice;
  out.t = INT64_MIN;
  for (int c = 0; c < setup_.cameras; ++c) {
    const bool present = (choice >> c & 1) != 0;
    lent_[out.id.slot][c] = present ? heads_[c].image.buffer : -1;
    if (present) out.t = std::max(out.t, heads_[c].image.t);
  }
  // Of one trigger, the left camera's stamp is the frame's.
  if (setup_.pairing == Pairing::kTrigger && choice == kBoth) out.t = heads_[0].image.t;
  for (int c = 0; c < setup_.cameras; ++c) {
    if ((choice >> c & 1) == 0) continue;
    const V4l2Image& image = heads_[c].image;
    out.image[c] = {image.data, setup_.camera[c].width, setup_.camera[c].height, image.stride};
    out.info[c].exposure_ns = image.exposure_ns;
    out.info[c].sequence = image.sequence;
    if (setup_.pairing == Pairing::kStamp) out.late[c] = out.t - image.t;
  }
  const int first = (choice & kLeft) != 0 ? 0 : 1;
  const uint32_t count = count_of(first);
  const bool counted = setup_.cameras == 1 || counts_known_;
  if (counted && has_last_) {
    out.lost_before = static_cast<uint32_t>(std::max(0, difference(count, last_count_) - 1));
  }
  last_count_ = count;
  has_last_ = counted;
  for (int c = 0; c < setup_.cameras; ++c) {
    if ((choice >> c & 1) != 0) heads_[c].here = false;
  }
  if (setup_.cameras == 1 || choice == kBoth) {
    ++counters_.pairs;
  } else {
    ++counters_.halves;
  }
  return Status::kOk;
}

Status V4l2Stereo::poll(StereoFrame& out) {
  bool any_camera = false;
  for (int c = 0; c < setup_.cameras; ++c) any_camera |= fetch(c);
  const Choice choice = choose();
  if (choice != 0) return lend(choice, out);
  return any_camera ? Status::kEmpty : gone_.answer();
}

}  // namespace pirvs::bsp
