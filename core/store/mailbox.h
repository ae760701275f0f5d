// The latest value from one writer core to one reader core; older ones are overwritten unread.
// In      Fill back() completely, then publish(): the next back() holds an older value.
// Out     take() gives the newest value not yet taken, valid until the next take().
// Errors  take: nullptr when nothing was published since the last take.
// Cost    One atomic exchange; neither side ever waits. Three copies of T.
// Source  Triple buffering: writer, reader and the middle each own one buffer at any time.
#pragma once

#include <atomic>
#include <cstdint>

namespace pirvs {

template <class T>
class Mailbox {
 public:
  T& back() { return buffers_[back_]; }
  void publish() { back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex; }
  [[nodiscard]] const T* take() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return nullptr;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return &buffers_[front_];
  }

 private:
  static constexpr uint32_t kIndex = 3;
  static constexpr uint32_t kFresh = 4;  // the middle buffer has not been taken yet

  T buffers_[3];
  alignas(64) uint32_t back_ = 0;   // the writer's
  alignas(64) uint32_t front_ = 1;  // the reader's
  alignas(64) std::atomic<uint32_t> middle_{2};
};

}  // namespace pirvs
