#include "board/linux/pins.h"

#include "bsp/api/clock.h"
#include "bsp/api/events.h"
#include "bsp/linux/events.h"
#include "modules/output/pose_at.h"

namespace pirvs::board {
namespace {

constexpr const char* kUser = "pirvsd";
constexpr TimeNs kPeriodUnknown_ns = 100'000'000;

}  // namespace

void Pins::tell_failure(const char* pin, const char* why) {
  if (why != nullptr && news_.tell != nullptr) news_.tell(news_.context, pin, why);
}

void Pins::open(const PinSettings& settings, bool urgent, const bsp::DeviceNews& news,
                const PinSinks& sinks) {
  settings_ = settings;
  news_ = news;
  sinks_ = sinks;
  const auto given = [](const SettingText& name) { return name.text[0] != 0; };
  if (given(settings_.health)) {
    const char* const name = settings_.health.text;
    tell_failure(name, health_pin_.open(name, false, kUser));
  }
  if (given(settings_.sync_out)) {
    const char* const name = settings_.sync_out.text;
    const char* why = sync_out_pin_.open(name, false, kUser);
    if (why == nullptr &&
        sync_out_.start(sync_out_pin_, settings_.sync_out_width_ns, urgent) != Status::kOk) {
      why = "no thread for its pulses";
    }
    tell_failure(name, why);
  }
  if (given(settings_.sync_in)) {
    const char* const name = settings_.sync_in.text;
    const bsp::EdgeKind kind =
        settings_.sync_in_is_pps ? bsp::EdgeKind::kRising : settings_.sync_in_edge;
    const char* const why = sync_in_.find(&name, 1);
    tell_failure(name, why != nullptr ? why : sync_in_.open(kind, kUser));
  }
  for (int side = 0; side < 2; ++side) {
    const SettingText(&names)[2] = settings_.wheel[side];
    if (!given(names[0])) continue;
    const char* const both[2] = {names[0].text, names[1].text};
    bsp::EdgePins& pins = wheels_[side].pins;
    const char* const why = pins.find(both, 2);
    tell_failure(both[0], why != nullptr ? why : pins.open(bsp::EdgeKind::kBoth, kUser));
    any_wheel_ |= pins.is_open();
  }
}

void Pins::close() {
  sync_out_.stop();
  sync_out_pin_.close();
  health_pin_.close();
  sync_in_.close();
  for (Wheel& wheel : wheels_) wheel.pins.close();
}

// ---- out ---------------------------------------------------------------------------------------

void Pins::frame_taken(TimeNs t) {
  exposures_.add(t);
  if (sync_out_pin_.is_open()) sync_out_.plan(exposures_.plan());
}

void Pins::set_health(bool good) {
  if (good == healthy_) return;
  healthy_ = good;
  if (!good) ++counters_.health_falls;
  if (health_pin_.is_open()) (void)health_pin_.write(good);
}

void Pins::health(HealthState state) {
  if (state != HealthState::kTracking) set_health(false);
}

// A frame is due a period after the one before, and may be as much late.
void Pins::judge_health(const Pose& pose) {
  if (pose.t_frame != fused_t_) {
    const TimeNs period = exposures_.plan().period_ns;
    fused_t_ = pose.t_frame;
    fused_due_t_ = bsp::now() + 2 * (period > 0 ? period : kPeriodUnknown_ns);
  }
  set_health(pose.health == HealthState::kTracking &&
             pose.trust.confidence >= settings_.health_confidence && bsp::now() < fused_due_t_);
}

// ---- in ----------------------------------------------------------------------------------------

void Pins::deliver(const Arrival& arrival) {
  if (sinks_.deliver(sinks_.context, arrival) != Status::kOk) ++counters_.not_delivered;
}

void Pins::read_sync_in() {
  if (!sync_in_.is_open()) return;
  look_t_ = bsp::now() + kLook_ns;
  bsp::GpioEdge edge;
  for (;;) {
    const Status status = sync_in_.poll(edge);
    if (status != Status::kOk && status != Status::kFull) return;
    ++counters_.sync_in_edges;
    deliver(arrival_of(edge, status == Status::kFull));
    if (settings_.sync_in_is_pps) take_pps(edge.t);
    if (!events_.push(edge)) ++counters_.sync_in_late;
  }
}

void Pins::take_pps(TimeNs t) {
  if (!pps_.add(t)) {
    ++counters_.pps_odd;
  } else if (pps_.known() && sinks_.pps != nullptr) {
    sinks_.pps(sinks_.context, pps_);
  }
}

void Pins::give_events(const Pose* pose) {
  const TimeNs now = bsp::now();
  while (const bsp::GpioEdge* const edge = events_.front()) {
    SyncEvent event;
    event.edge = *edge;
    if (pose != nullptr && edge->t <= pose->state.t) {
      event.has_pose = has_last_pose_ && last_pose_.state.t <= edge->t &&
                       last_pose_.epoch == pose->epoch &&
                       pose->state.t - last_pose_.state.t < kNoPose_ns;
      if (event.has_pose) event.pose = pose_at(last_pose_, *pose, edge->t);
    } else if (now - edge->t < kNoPose_ns) {
      return;  // the pose after it will come
    }
    if (!event.has_pose) ++counters_.sync_in_late;
    if (sinks_.event != nullptr) sinks_.event(sinks_.context, event);
    events_.pop();
  }
}

void Pins::pose(const Pose& pose) {
  judge_health(pose);
  read_sync_in();
  give_events(&pose);
  last_pose_ = pose;
  has_last_pose_ = true;
}

void Pins::poll_wheels() {
  const TimeNs now = bsp::now();
  if (!any_wheel_ || now < wheel_look_t_) return;
  wheel_look_t_ = now + kLook_ns;
  for (Wheel& wheel : wheels_) {
    bsp::GpioEdge edge;
    for (;;) {
      const Status status = wheel.pins.poll(edge);
      if (status != Status::kOk && status != Status::kFull) break;
      if (status == Status::kFull) wheel.encoder.lost(1);
      wheel.encoder.add(wheel.pins.index_of(edge.pin), edge.level);
      ++counters_.wheel_edges;
    }
    counters_.wheel_missed += wheel.encoder.missed() - wheel.missed_told;
    wheel.missed_told = wheel.encoder.missed();
  }
  if (now < wheel_t_) return;
  WheelSample sample;
  sample.t = now;
  sample.kind = WheelKind::kTicks;
  for (int side = 0; side < 2; ++side) {
    sample.value[side] = static_cast<double>(wheels_[side].encoder.ticks());
  }
  deliver(arrival_of(sample));
  wheel_t_ = now + kWheelPeriod_ns;
}

void Pins::poll() {
  const bool due = bsp::take_ready(0, sync_in_.fd()) || bsp::now() >= look_t_;
  if (due) read_sync_in();
  if (events_.size() > 0) give_events(nullptr);
  poll_wheels();
  if (!healthy_) return;
  if (bsp::now() >= fused_due_t_) {
    set_health(false);
  } else {
    bsp::alarm(fused_due_t_);
  }
}

}  // namespace pirvs::board
