// Driver of the InvenSense ICM-20602 on I2C: 200 samples a second by its FIFO, each with the time
// of its own interrupt.
// In      data_ready: the stamp of each rising edge of the chip's INT pin (bsp/api/gpio.h), in
//         order. step: call at least every millisecond with the time; it carries one transfer on.
// Out     poll: bsp/api/imu.h. The n-th newest sample in the FIFO belongs to the n-th newest edge:
//         the FIFO is counted only within kQuiet of an edge, when no other sample can come in
//         between.
// Frames  B: the chip's own axes.
// Errors  set_up: kNotFound: another chip answers; kBusFault, kTimeout as bsp/api/i2c.h. step: kOk,
//         or once: kBusFault, kTimeout: a transfer failed, it is tried again; kStale: no edge for
//         kSilence; kBadData: the set-up no longer holds (the chip was reset). After the last two,
//         call set_up. poll: kFull: samples were lost before this one.
// Cost    set_up waits 0.2 s. A sample takes about 0.6 ms of a 400 kHz bus, a step a few accesses.
// Source  icm20602_registers.h; PX4's habit of reading the set-up back.
#pragma once

#include <cstdint>

#include "bsp/api/imu.h"
#include "bsp/drivers/icm20602/icm20602_registers.h"
#include "core/store/ring.h"

namespace pirvs::bsp {

// False: not a sample (an empty FIFO reads as ones).
bool icm20602_decode(const uint8_t* packet, ImuSample& out);

class Icm20602 {
 public:
  static constexpr TimeNs kPeriod = 5'000'000;
  static constexpr TimeNs kQuiet = 2'000'000;
  static constexpr TimeNs kSilence = 50'000'000;
  // What the chip keeps while nobody reads it.
  static constexpr TimeNs kFifo = TimeNs{icm20602::kFifoBytes / icm20602::kPacketBytes} * kPeriod;

  struct Counters {
    uint32_t lost = 0;      // samples that the FIFO or we had no room for
    uint32_t guessed = 0;   // stamps made from a neighbour's: their edge was missed
    uint32_t rejected = 0;  // packets that were none
  };

  constexpr Icm20602(int bus, uint8_t address) : bus_(bus), address_(address) {}

  Status set_up();
  void data_ready(TimeNs t);
  Status step(TimeNs now);
  Status poll(ImuSample& out);
  // A transfer is under way or due: step() has more to do without another edge.
  bool busy() const { return stage_ != Stage::kIdle || check_due_; }
  float temperature_C() const { return temperature_C_; }  // with the newest sample
  const Counters& counters() const { return counters_; }

 private:
  static constexpr size_t kBatch = 8;  // packets a transfer
  static constexpr size_t kEdgesMax = 128;
  enum class Stage : uint8_t { kIdle, kCounting, kFetching, kChecking, kEmptying };

  Status write(uint8_t reg, uint8_t value);
  Status begin_read(Stage stage, uint8_t reg, size_t size);
  Status begin(TimeNs now);
  Status finish(TimeNs now);
  Status counted(TimeNs now);
  void fetched();
  Status checked();
  TimeNs stamp_of(size_t packet) const;
  void forget_edges(size_t count);
  void deliver(const ImuSample& sample);

  int bus_;
  uint8_t address_;
  Stage stage_ = Stage::kIdle;
  uint8_t request_[2] = {};
  uint8_t answer_[kBatch * icm20602::kPacketBytes] = {};

  // Edges whose samples are still in the FIFO, the oldest first.
  TimeNs edges_[kEdgesMax] = {};
  size_t edge_count_ = 0;
  TimeNs newest_t_ = 0;
  size_t edges_counted_ = 0;     // of them, when the count of the FIFO began
  TimeNs newest_counted_t_ = 0;  // the newest of those

  size_t waiting_ = 0;      // packets in the FIFO when it was counted
  size_t unedged_ = 0;      // the oldest of these that no edge announced
  size_t fetching_ = 0;     // packets of the transfer under way
  size_t check_row_ = 0;    // the next row of the set-up to read back
  bool check_due_ = false;  // one row after each batch
  bool lost_some_ = false;
  float temperature_C_ = 0;
  Ring<ImuSample, 32> samples_;
  Counters counters_;
};

}  // namespace pirvs::bsp
