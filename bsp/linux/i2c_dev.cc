#include "bsp/linux/i2c_dev.h"

#include <errno.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>

#include "core/base/text.h"

namespace pirvs::bsp {

void I2cDev::close() {
  if (fd_ >= 0) calls_->close(fd_);
  fd_ = -1;
}

Status I2cDev::transfer(int bus, const I2cTransfer& transfer, const SystemCalls& calls) {
  if (transfer.out_size + transfer.in_size == 0) return Status::kBadData;
  if (transfer.in_size > 0 && transfer.out_size > kI2cWriteMax) return Status::kBadData;
  if (fd_ < 0 || bus != bus_) {
    close();
    calls_ = &calls;
    Text<32> path;
    path.put("/dev/i2c-").number(bus);
    fd_ = calls.open(path.c_str());
    bus_ = bus;
    if (fd_ < 0) return Status::kNotFound;
  }
  i2c_msg messages[2];
  unsigned count = 0;
  if (transfer.out_size > 0) {
    messages[count++] = {transfer.address, 0, static_cast<uint16_t>(transfer.out_size),
                         const_cast<uint8_t*>(transfer.out)};
  }
  if (transfer.in_size > 0) {
    messages[count++] = {transfer.address, I2C_M_RD, static_cast<uint16_t>(transfer.in_size),
                         transfer.in};
  }
  i2c_rdwr_ioctl_data both = {messages, count};
  if (calls_->ioctl(fd_, I2C_RDWR, &both) == static_cast<int>(count)) return Status::kOk;
  const int why = errno;
  if (why == ENODEV || why == EBADF) close();  // the bus itself is gone
  return why == ETIMEDOUT ? Status::kTimeout : Status::kBusFault;
}

}  // namespace pirvs::bsp
