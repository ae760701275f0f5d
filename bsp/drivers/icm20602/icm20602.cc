#include "bsp/drivers/icm20602/icm20602.h"

#include <algorithm>

#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/i2c.h"

namespace pirvs::bsp {

using namespace icm20602;

namespace {

constexpr TimeNs kResetTime = 100'000'000;  // start-up time of the register map, data sheet 3.2
constexpr double kPi = 3.14159265358979323846;
constexpr double kRate_rad_s = 2000.0 / 32768.0 * kPi / 180.0;
constexpr double kForce_m_s2 = 8.0 / 32768.0 * 9.80665;

double big_endian(const uint8_t* bytes) {
  return static_cast<int16_t>(static_cast<uint16_t>(bytes[0] << 8 | bytes[1]));
}

// Data sheet 11.25: 326.8 counts a degree, 0 at 25 degrees.
float temperature_of(const uint8_t* packet) {
  return static_cast<float>(big_endian(packet + 6)) / 326.8f + 25.0f;
}

void wait(TimeNs duration) {
  const TimeNs end = now() + duration;
  while (now() < end) relax();
}

}  // namespace

// Accelerometer, temperature, gyroscope: big-endian words.
bool icm20602_decode(const uint8_t* packet, ImuSample& out) {
  if (std::all_of(packet, packet + kPacketBytes, [](uint8_t b) { return b == 0xff; })) return false;
  for (int axis = 0; axis < 3; ++axis) {
    out.f_B(axis) = kForce_m_s2 * big_endian(packet + 2 * axis);
    out.w_B(axis) = kRate_rad_s * big_endian(packet + 8 + 2 * axis);
  }
  return true;
}

Status Icm20602::write(uint8_t reg, uint8_t value) {
  const uint8_t out[] = {reg, value};
  return i2c_transfer(bus_, {address_, out, sizeof out, nullptr, 0});
}

Status Icm20602::set_up() {
  while (stage_ != Stage::kIdle) {  // a transfer of ours may still be under way
    if (i2c_poll(bus_) != Status::kEmpty) stage_ = Stage::kIdle;
  }
  uint8_t identity = 0;
  PIRVS_TRY(i2c_transfer(bus_, {address_, &kWHO_AM_I, 1, &identity, 1}));
  if (identity != kIdentity) return Status::kNotFound;
  PIRVS_TRY(write(kPWR_MGMT_1, kDeviceReset));
  wait(kResetTime);
  for (const SetupByte& row : kSetup) PIRVS_TRY(write(row.address, row.value));
  PIRVS_TRY(write(kUSER_CTRL, kFifoEnable | kFifoReset));
  counters_.lost += static_cast<uint32_t>(edge_count_);  // what they announced is not read any more
  lost_some_ |= edge_count_ > 0;
  edge_count_ = waiting_ = unedged_ = check_row_ = 0;
  check_due_ = false;
  newest_t_ = now();
  return Status::kOk;
}

void Icm20602::data_ready(TimeNs t) {
  newest_t_ = t;
  if (edge_count_ == kEdgesMax) forget_edges(1);  // the FIFO holds fewer: it is full by now
  edges_[edge_count_++] = t;
}

Status Icm20602::step(TimeNs now) {
  if (stage_ == Stage::kIdle) return begin(now);
  const Status status = i2c_poll(bus_);
  if (status == Status::kEmpty) return Status::kOk;
  if (status == Status::kOk) return finish(now);
  stage_ = Stage::kIdle;
  return status;
}

Status Icm20602::poll(ImuSample& out) {
  const ImuSample* sample = samples_.front();
  if (sample == nullptr) return Status::kEmpty;
  out = *sample;
  samples_.pop();
  const bool lost = lost_some_;
  lost_some_ = false;
  return lost ? Status::kFull : Status::kOk;
}

Status Icm20602::begin_read(Stage stage, uint8_t reg, size_t size) {
  request_[0] = reg;
  PIRVS_TRY(i2c_start(bus_, {address_, request_, 1, answer_, size}));
  stage_ = stage;
  return Status::kOk;
}

Status Icm20602::begin(TimeNs now) {
  if (check_due_) {
    check_due_ = false;
    return begin_read(Stage::kChecking, kSetup[check_row_].address, 1);
  }
  if (now - newest_t_ > kSilence) {
    newest_t_ = now;  // said once
    return Status::kStale;
  }
  if (edge_count_ == 0 || now - newest_t_ > kQuiet) return Status::kOk;
  edges_counted_ = edge_count_;
  newest_counted_t_ = newest_t_;
  return begin_read(Stage::kCounting, kFIFO_COUNTH, 2);
}

Status Icm20602::finish(TimeNs now) {
  const Stage stage = stage_;
  stage_ = Stage::kIdle;
  if (stage == Stage::kCounting) return counted(now);
  if (stage == Stage::kFetching) fetched();
  if (stage == Stage::kChecking) return checked();
  return Status::kOk;
}

Status Icm20602::counted(TimeNs now) {
  const size_t bytes = size_t{answer_[0]} << 8 | answer_[1];
  waiting_ = bytes / kPacketBytes;
  const bool full = bytes + kPacketBytes > kFifoBytes;
  // Another sample may have come between the edge and the count on the bus: which one is counted?
  const bool disturbed = now - newest_counted_t_ > kPeriod - kQuiet || bytes % kPacketBytes != 0;
  if (disturbed && !full) return Status::kOk;  // count again after the next edge
  if (full) {
    counters_.lost += static_cast<uint32_t>(std::max(edge_count_, waiting_));
    lost_some_ = true;
    edge_count_ = 0;
    request_[0] = kUSER_CTRL;
    request_[1] = kFifoEnable | kFifoReset;
    PIRVS_TRY(i2c_start(bus_, {address_, request_, 2, nullptr, 0}));
    stage_ = Stage::kEmptying;
    return Status::kOk;
  }
  if (edges_counted_ > waiting_) {
    counters_.lost += static_cast<uint32_t>(edges_counted_ - waiting_);
    lost_some_ = true;
    forget_edges(edges_counted_ - waiting_);
    edges_counted_ = waiting_;
  }
  unedged_ = waiting_ - edges_counted_;
  fetching_ = std::min(waiting_, kBatch);
  if (fetching_ == 0) return Status::kOk;
  return begin_read(Stage::kFetching, kFIFO_R_W, fetching_ * kPacketBytes);
}

// The oldest packet is 0.
TimeNs Icm20602::stamp_of(size_t packet) const {
  if (packet >= unedged_) return edges_[packet - unedged_];
  return edges_[0] - static_cast<TimeNs>(unedged_ - packet) * kPeriod;
}

void Icm20602::forget_edges(size_t count) {
  std::copy(edges_ + count, edges_ + edge_count_, edges_);
  edge_count_ -= count;
}

void Icm20602::fetched() {
  for (size_t i = 0; i < fetching_; ++i) {
    ImuSample sample;
    sample.t = stamp_of(i);
    counters_.guessed += i < unedged_ ? 1 : 0;
    const uint8_t* const packet = answer_ + i * kPacketBytes;
    if (icm20602_decode(packet, sample)) {
      temperature_C_ = temperature_of(packet);
      deliver(sample);
    } else {
      ++counters_.rejected;
    }
  }
  forget_edges(fetching_ - std::min(fetching_, unedged_));
  check_due_ = true;
}

void Icm20602::deliver(const ImuSample& sample) {
  if (samples_.push(sample)) return;
  ++counters_.lost;
  lost_some_ = true;
}

Status Icm20602::checked() {
  const bool holds = answer_[0] == kSetup[check_row_].value;
  check_row_ = (check_row_ + 1) % kSetupRows;
  return holds ? Status::kOk : Status::kBadData;
}

}  // namespace pirvs::bsp
