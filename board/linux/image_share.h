// Gives the cameras' images to one other program, while it looks: a ring of slots in shared memory,
// into which an image is copied when that program has asked for its camera.
// In      open(): the socket's path, the images' size; before the first frame. frame(): each one,
//         while its images are valid, on the core that polls the cameras.
// Out     board/linux/image_protocol.h. The client can only read the memory.
// Errors  open: kBusFault (no socket there, no memory). Nobody is waited for: while all slots are
//         with the client, or when it does not read its messages, its images are lost and counted.
//         One that is gone, or says what makes no sense, is let go, and the next one may come. A
//         second one is turned away.
// Cost    Without a client: a clock reading a frame, and a system call every kAsk_ns; ~0.1 us a
//         frame on x86-64. With one: a copy of the image and two system calls, ~40 us at 640 x 480.
// Source  memfd_create(2), F_SEAL_FUTURE_WRITE.
#pragma once

#include "board/linux/image_protocol.h"
#include "bsp/api/camera.h"
#include "core/base/counter.h"

namespace pirvs::board {

struct ImageShareCounters {
  Counter clients, refused, sent, lost;
};
inline constexpr CounterRow<ImageShareCounters> kImageShareRows[] = {
    {"clients", &ImageShareCounters::clients},
    {"refused", &ImageShareCounters::refused},  // another one was there, or it talked nonsense
    {"sent", &ImageShareCounters::sent},
    {"lost", &ImageShareCounters::lost},
};
static_assert(every_counter_is_in(kImageShareRows));

class ImageShare {
 public:
  static constexpr TimeNs kAsk_ns = 100'000'000;
  static constexpr uint32_t kSlots = 2     // one each in the making
                                     + 2;  // and one each that the client reads

  Status open(const char* path, int cameras, int width, int height);
  void frame(const StereoFrame& frame);
  void close();

  bool is_open() const { return listener_ >= 0; }
  const ImageShareCounters& counters() const { return counters_; }

 private:
  Status make_memory();
  void look_for_client(TimeNs now);
  void welcome(int client);
  void listen_to_client();
  bool obey(const ImageRequest& request);
  void share(const StereoFrame& frame, int camera);
  void drop_client();

  int listener_ = -1, client_ = -1, memory_fd_ = -1;
  const char* path_ = "";
  uint8_t* memory_ = nullptr;
  ImageRing ring_;
  uint32_t wanted_ = 0;       // cameras, by bit
  uint32_t with_client_ = 0;  // slots, by bit
  uint32_t lost_ = 0;
  TimeNs asked_t_ = 0;
  ImageShareCounters counters_;
};

}  // namespace pirvs::board
