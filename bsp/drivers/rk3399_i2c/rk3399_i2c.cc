#include "bsp/drivers/rk3399_i2c/rk3399_i2c.h"

#include <algorithm>

#include "bsp/drivers/rk3399_i2c/rk3399_i2c_registers.h"

namespace pirvs::bsp {

using namespace rk3399_i2c;

Status Rk3399I2c::open(uint32_t scl_hz) {
  if (scl_hz == 0) return Status::kBadData;
  const uint32_t eighths =
      (clock_hz_ - 1) / (8 * scl_hz) + 1;  // of a period, in clocks: rounded up
  const uint32_t low = (eighths * 3 + 4) / 5;
  const uint32_t high = eighths - low;
  if (high == 0 || low > 0x10000) return Status::kBadData;
  registers_.write(kCON, 0);
  registers_.write(kCLKDIV, (high - 1) << 16 | (low - 1));
  registers_.write(kIEN, 0);
  stage_ = Stage::kIdle;
  return Status::kOk;
}

Status Rk3399I2c::start(const I2cTransfer& transfer, TimeNs now) {
  if (stage_ != Stage::kIdle) return Status::kFull;
  if (transfer.in_size > 0 && transfer.out_size > kI2cWriteMax) return Status::kBadData;
  if (transfer.in_size == 0 && transfer.out_size == 0) return Status::kBadData;
  transfer_ = transfer;
  stage_ = Stage::kStarting;
  outcome_ = Status::kOk;
  done_ = 0;
  deadline_ = now + kI2cTimeout;
  const uint32_t mode = reads() ? kConModeAddressRx : kConModeTx;
  registers_.write(kIPD, kIpdAll);
  registers_.write(kCON, kConEnable | mode | kConStart | kConNackStops);
  return Status::kOk;
}

Status Rk3399I2c::poll(TimeNs now) {
  if (stage_ == Stage::kIdle) return Status::kStale;
  const uint32_t pending = registers_.read(kIPD);
  if ((pending & kIpdNack) != 0 && stage_ != Stage::kStopping) {
    registers_.write(kIPD, kIpdNack);
    stop(Status::kBusFault);
  } else if (stage_ == Stage::kStarting && (pending & kIpdStart) != 0) {
    registers_.write(kIPD, kIpdStart);
    begin_data();
  } else if (stage_ == Stage::kWriting && (pending & kIpdTxDone) != 0) {
    registers_.write(kIPD, kIpdTxDone);
    if (done_ == transfer_.out_size) {
      stop(Status::kOk);
    } else {
      write_message();
    }
  } else if (stage_ == Stage::kReading && (pending & kIpdRxDone) != 0) {
    registers_.write(kIPD, kIpdRxDone | kIpdStart);
    take_message();
    if (done_ == transfer_.in_size) {
      stop(Status::kOk);
    } else {
      ask_for_message();
    }
  } else if (stage_ == Stage::kStopping && (pending & kIpdStop) != 0) {
    registers_.write(kIPD, kIpdStop);
    return end(outcome_);
  } else if (now > deadline_) {
    return end(Status::kTimeout);
  }
  return Status::kEmpty;
}

// Switching the controller off also forgets a message that the bus never let out.
Status Rk3399I2c::end(Status status) {
  registers_.write(kCON, 0);
  stage_ = Stage::kIdle;
  return status;
}

void Rk3399I2c::stop(Status status) {
  outcome_ = status;
  stage_ = Stage::kStopping;
  registers_.change(kCON, kConStart | kConStop, kConStop);
}

void Rk3399I2c::begin_data() {
  registers_.change(kCON, kConStart, 0);
  if (!reads()) {
    stage_ = Stage::kWriting;
    write_message();
    return;
  }
  // With no register's address the first byte on the bus asks to read at once.
  const bool has_register = transfer_.out_size > 0;
  registers_.write(kMRXADDR,
                   address_valid(0) | uint32_t{transfer_.address} << 1 | (has_register ? 0u : 1u));
  uint32_t place = 0;
  for (uint32_t i = 0; i < transfer_.out_size; ++i) {
    place |= address_valid(i) | uint32_t{transfer_.out[i]} << (8 * i);
  }
  registers_.write(kMRXRADDR, place);
  stage_ = Stage::kReading;
  ask_for_message();
}

// The chip's address is the first byte of the first message.
void Rk3399I2c::write_message() {
  uint32_t words[kDataWords] = {};
  uint32_t size = 0;
  const auto append = [&](uint8_t byte) {
    words[size / 4] |= uint32_t{byte} << (size % 4 * 8);
    ++size;
  };
  if (done_ == 0) append(static_cast<uint8_t>(transfer_.address << 1));
  while (size < kMessageBytes && done_ < transfer_.out_size) append(transfer_.out[done_++]);
  for (uint32_t i = 0; i < (size + 3) / 4; ++i) registers_.write_at(kTXDATA0, i, words[i]);
  registers_.write(kMTXCNT, size);
}

void Rk3399I2c::ask_for_message() {
  const size_t left = transfer_.in_size - done_;
  const uint32_t last = left <= kMessageBytes ? kConLastNack : 0;
  registers_.change(kCON, kConLastNack, last);
  if (done_ > 0) registers_.change(kCON, kConModeMask, kConModeRx);
  registers_.write(kMRXCNT, static_cast<uint32_t>(std::min<size_t>(left, kMessageBytes)));
}

void Rk3399I2c::take_message() {
  const size_t size = std::min<size_t>(transfer_.in_size - done_, kMessageBytes);
  uint32_t word = 0;
  for (uint32_t i = 0; i < size; ++i) {
    if (i % 4 == 0) word = registers_.read_at(kRXDATA0, i / 4);
    transfer_.in[done_++] = static_cast<uint8_t>(word >> (i % 4 * 8));
  }
}

}  // namespace pirvs::bsp
