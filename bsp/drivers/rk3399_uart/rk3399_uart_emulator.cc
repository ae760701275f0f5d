#include "bsp/drivers/rk3399_uart/rk3399_uart_emulator.h"

namespace pirvs::bsp::emulated {

using namespace rk3399_uart;

uint32_t Rk3399UartChip::line_status() {
  uint32_t status = tx_.size() == 0 ? 0x60u : 0u;  // THRE, TEMT
  if (const Received* first = rx_.front(); first != nullptr) {
    status |= kLsrDataReady | first->errors;
  }
  if (overrun_) status |= kLsrOverrun;
  overrun_ = false;
  return status;
}

uint8_t Rk3399UartChip::take() {
  PIRVS_ASSERT(rx_.size() > 0);
  const uint8_t byte = rx_.front()->byte;
  rx_.pop();
  return byte;
}

uint32_t Rk3399UartChip::read(uint32_t offset) {
  if (offset == kRBR_THR_DLL.offset) return divisor_open() ? divisor_ & 0xff : take();
  if (offset == kIER_DLH.offset && divisor_open()) return divisor_ >> 8;
  if (offset == kLSR.offset) return line_status();
  const bool full = tx_.size() == kFifoBytes;
  file_.poke(kUSR, (busy() ? kUsrBusy : 0u) | (full ? 0u : kUsrTxNotFull));
  file_.poke(kTFL, static_cast<uint32_t>(tx_.size()));
  file_.poke(kRFL, static_cast<uint32_t>(rx_.size()));
  return file_.load(offset);
}

void Rk3399UartChip::write(uint32_t offset, uint32_t value) {
  if (offset == kRBR_THR_DLL.offset && !divisor_open()) {
    const bool had_room = tx_.push(static_cast<uint8_t>(value));
    PIRVS_ASSERT(had_room);
  } else if (offset == kRBR_THR_DLL.offset) {
    divisor_ = (divisor_ & 0xff00) | (value & 0xff);
  } else if (offset == kIER_DLH.offset && divisor_open()) {
    divisor_ = (divisor_ & 0xff) | (value & 0xff) << 8;
  } else if (offset == kIIR_FCR.offset) {
    while ((value & kFcrResetRx) != 0 && rx_.size() > 0) rx_.pop();
    while ((value & kFcrResetTx) != 0 && tx_.size() > 0) tx_.pop();
  } else if (offset != kLCR.offset || !busy()) {
    file_.store(offset, value);
  }
}

void Rk3399UartChip::send_out(int bytes) {
  for (; bytes > 0 && tx_.size() > 0 && sent_size_ < kSentMax; --bytes) {
    sent_[sent_size_++] = *tx_.front();
    tx_.pop();
  }
}

void Rk3399UartChip::receive(uint8_t byte, uint32_t line_errors) {
  overrun_ |= !rx_.push({byte, line_errors});
}

}  // namespace pirvs::bsp::emulated
