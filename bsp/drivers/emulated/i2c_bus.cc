#include "bsp/drivers/emulated/i2c_bus.h"

#include "core/base/assert.h"

namespace pirvs::bsp {
namespace emulated {
namespace {

constexpr int kBuses = 10;
constexpr int kPolls = 2;

struct Bus {
  I2cTransfer transfer;
  int polls_left = 0;  // 0: nothing runs
};

I2cSlave slaves[kI2cDevicesMax];
Bus buses[kBuses];
Status next_status = Status::kOk;
int transfers = 0;

const I2cSlave* find(int bus, uint8_t address_and_read) {
  for (const I2cSlave& slave : slaves) {
    if (slave.bus == bus && slave.start(slave.self, address_and_read)) return &slave;
  }
  return nullptr;
}

Status run(int bus, const I2cTransfer& transfer) {
  const uint8_t address = static_cast<uint8_t>(transfer.address << 1);
  const bool reads_at_once = transfer.out_size == 0;
  const I2cSlave* slave = find(bus, reads_at_once ? address | 1 : address);
  if (slave == nullptr) return Status::kBusFault;
  for (size_t i = 0; i < transfer.out_size; ++i) {
    if (!slave->write(slave->self, transfer.out[i])) return Status::kBusFault;
  }
  if (!reads_at_once && transfer.in_size > 0) slave->start(slave->self, address | 1);
  for (size_t i = 0; i < transfer.in_size; ++i) {
    transfer.in[i] = slave->read(slave->self, i + 1 < transfer.in_size);
  }
  return Status::kOk;
}

}  // namespace

int I2cAttachment::attach(const I2cSlave& slave) {
  PIRVS_ASSERT(slave.bus >= 0 && slave.bus < kBuses);
  int free = 0;
  while (free < kI2cDevicesMax && slaves[free].bus >= 0) ++free;
  PIRVS_ASSERT(free < kI2cDevicesMax);
  slaves[free] = slave;
  return free;
}

void I2cAttachment::detach(int slot) { slaves[slot] = I2cSlave{}; }

void i2c_fail_next(Status status) { next_status = status; }
int i2c_transfers() { return transfers; }

}  // namespace emulated

Status i2c_start(int bus, const I2cTransfer& transfer) {
  using namespace emulated;
  if (bus < 0 || bus >= kBuses) return Status::kNotFound;
  if (buses[bus].polls_left > 0) return Status::kFull;
  if (transfer.in_size > 0 && transfer.out_size > kI2cWriteMax) return Status::kBadData;
  if (transfer.in_size == 0 && transfer.out_size == 0) return Status::kBadData;
  buses[bus] = {transfer, kPolls};
  return Status::kOk;
}

Status i2c_poll(int bus) {
  using namespace emulated;
  if (bus < 0 || bus >= kBuses || buses[bus].polls_left == 0) return Status::kStale;
  if (--buses[bus].polls_left > 0) return Status::kEmpty;
  ++transfers;
  const Status failed = next_status;
  next_status = Status::kOk;
  return failed != Status::kOk ? failed : run(bus, buses[bus].transfer);
}

}  // namespace pirvs::bsp
