#include "board/bare/robot_link.h"

#include "bsp/api/serial.h"
#include "modules/link/replay_link.h"

namespace pirvs::board {
namespace {

constexpr int kPort = 0;
constexpr uint32_t kBaud = 115'200;
constexpr size_t kBytesAtOnce = 64;

ReplayLink link;

bool send(void*, const uint8_t* frame, size_t size) {
  return bsp::serial_write(kPort, frame, size) == size;
}

}  // namespace

Status robot_link_open(App& app, const ImuNoise& noise) {
  PIRVS_TRY(bsp::serial_open(kPort, kBaud));
  LinkStack stack;
  stack.context = &app;
  stack.command = [](void* to, const Command& c) { return static_cast<App*>(to)->command(c); };
  stack.deliver = [](void* to, const Arrival& a) { return static_cast<App*>(to)->deliver(a); };
  return link.open(LinkSetup{}, noise, stack, {nullptr, send}, app.poses());
}

void robot_link_poll(void*) {
  uint8_t bytes[kBytesAtOnce];
  size_t count = 0;
  if (bsp::serial_read(kPort, bytes, sizeof bytes, count) == Status::kOk) {
    link.link().receive(link.now(), bytes, count);
  }
  link.poll();
}

void robot_link_frame(TimeNs t) {
  if (link.is_open()) link.frame(t);
}

void robot_link_health(HealthState state, const char* what) {
  if (link.is_open()) link.link().health(state, what);
}

void robot_link_answer(const Answer& answer) {
  if (link.is_open()) link.link().answer(answer);
}

void robot_link_close() { link.close(); }

}  // namespace pirvs::board
