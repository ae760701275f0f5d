#include "bsp/linux/pins.h"

#include <errno.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/gpio.h>
#include <unistd.h>

#include <cstring>
#include <string>

namespace pirvs::bsp {
namespace {

// A chip whose lines' events are written to a pipe.
struct FakeChip {
  gpio_v2_line_request asked{};
  int write_fd = -1;
  int refuse = 0;  // errno of the request
  std::string opened;
} chip;

constexpr SystemCalls kFake = {
    [](const char* path) {
      chip.opened = path;
      return open("/dev/null", O_RDWR);
    },
    [](int fd) { return close(fd); },
    [](int, unsigned long request, void* argument) {
      EXPECT_EQ(request, GPIO_V2_GET_LINE_IOCTL);
      if (chip.refuse != 0) {
        errno = chip.refuse;
        return -1;
      }
      auto& asked = *static_cast<gpio_v2_line_request*>(argument);
      int ends[2];
      EXPECT_EQ(pipe(ends), 0);
      asked.fd = ends[0];
      chip.write_fd = ends[1];
      chip.asked = asked;
      return 0;
    },
    nullptr,
    nullptr,
};

class edge_pins : public testing::Test {
 protected:
  void SetUp() override { chip = {}; }
  void TearDown() override {
    if (chip.write_fd >= 0) close(chip.write_fd);
  }
  static void happen(uint32_t number, uint64_t t, uint32_t line, bool up) {
    gpio_v2_line_event event{};
    event.timestamp_ns = t;
    event.offset = line;
    event.seqno = number;
    event.id = up ? GPIO_V2_LINE_EVENT_RISING_EDGE : GPIO_V2_LINE_EVENT_FALLING_EDGE;
    ASSERT_EQ(write(chip.write_fd, &event, sizeof event), ssize_t(sizeof event));
  }
  const char* open_encoder() {
    const char* const names[] = {"gpiochip2:11", "gpiochip2:12"};
    const char* const why = pins_.find(names, 2);
    return why != nullptr ? why : pins_.open(EdgeKind::kBoth, "pirvsd", kFake);
  }
  EdgePins pins_;
  GpioEdge edge_;
};

TEST_F(edge_pins, come_in_order_with_the_kernels_stamps) {
  ASSERT_EQ(open_encoder(), nullptr);
  EXPECT_EQ(chip.opened, "/dev/gpiochip2");
  EXPECT_EQ(chip.asked.num_lines, 2u);
  EXPECT_EQ(chip.asked.offsets[1], 12u);
  EXPECT_EQ(chip.asked.event_buffer_size, EdgePins::kKernelEdges);
  EXPECT_STREQ(chip.asked.consumer, "pirvsd");
  EXPECT_EQ(pins_.poll(edge_), Status::kEmpty);
  for (uint32_t i = 1; i <= 200; ++i) happen(i, 1000 + i, 11 + i % 2, i % 4 < 2);
  for (uint32_t i = 1; i <= 200; ++i) {
    ASSERT_EQ(pins_.poll(edge_), Status::kOk) << i;
    EXPECT_EQ(edge_.t, TimeNs(1000 + i));
    EXPECT_EQ(pins_.index_of(edge_.pin), int(i % 2));
    EXPECT_EQ(edge_.level, i % 4 < 2);
  }
  EXPECT_EQ(pins_.poll(edge_), Status::kEmpty);
  EXPECT_EQ(pins_.lost(), 0u);
}

TEST_F(edge_pins, tell_what_the_kernel_had_no_room_for) {
  ASSERT_EQ(open_encoder(), nullptr);
  happen(1, 10, 11, true);
  happen(5, 50, 11, true);
  happen(6, 60, 11, false);
  EXPECT_EQ(pins_.poll(edge_), Status::kOk);
  EXPECT_EQ(pins_.poll(edge_), Status::kFull);
  EXPECT_EQ(edge_.t, 50) << "which is good";
  EXPECT_EQ(pins_.poll(edge_), Status::kOk);
  EXPECT_EQ(pins_.lost(), 3u);
}

TEST_F(edge_pins, that_cannot_be_had_say_why) {
  chip.refuse = EBUSY;
  EXPECT_NE(std::string(open_encoder()).find("busy"), std::string::npos);
  chip.refuse = EPERM;
  EXPECT_NE(std::string(open_encoder()).find("no right"), std::string::npos);
  chip.refuse = EINVAL;
  EXPECT_NE(std::string(open_encoder()).find("no such pin"), std::string::npos);
  EXPECT_EQ(pins_.poll(edge_), Status::kBusFault);
  for (const char* name : {"gpiochip2:", ":3", "gpiochip2:x", "gpiochip2:-1", "no_such_line"}) {
    EXPECT_NE(pins_.find(&name, 1), nullptr) << name;
  }
  const char* const apart[] = {"gpiochip1:1", "gpiochip2:1"};
  EXPECT_NE(pins_.find(apart, 2), nullptr);
  EXPECT_NE(pins_.open(EdgeKind::kBoth, "pirvsd", kFake), nullptr) << "none was found";
}

TEST_F(edge_pins, of_a_chip_that_is_gone_are_a_bus_fault) {
  ASSERT_EQ(open_encoder(), nullptr);
  close(chip.write_fd);
  chip.write_fd = -1;
  EXPECT_EQ(pins_.poll(edge_), Status::kBusFault);
}

}  // namespace
}  // namespace pirvs::bsp
