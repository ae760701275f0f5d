#include "bsp/bare/fault.h"

#include <atomic>

#include "bsp/api/clock.h"
#include "bsp/api/console.h"
#include "bsp/bare/core_setup.h"
#include "bsp/bare/firmware.h"
#include "bsp/bare/interrupts.h"
#include "bsp/bare/machine.h"
#include "bsp/bare/registers.h"
#include "bsp/bare/stacks.h"
#include "bsp/drivers/syndrome/syndrome.h"
#include "core/base/assert.h"
#include "core/base/text.h"

extern "C" [[noreturn]] void bare_restart();  // start.S
extern "C" void bare_core_start();
extern "C" char __text_end[], __image_begin[];

namespace pirvs::bsp {
namespace {

constexpr uint32_t kStopMessage = 1;  // to the other cores: switch yourself off
constexpr int kCallersMax = 24;
constexpr TimeNs kStopping_ns = 100'000'000;
constexpr uint64_t kRestart = 0x100;  // RESTART of arch.h: core 0 shall start again

[[gnu::section(".kept")]] KeptFault kept;
[[gnu::section(".kept")]] bool restarted_once;

// The core whose report it is, plus 1. Kept, as other cores may look while core 0 starts again.
[[gnu::section(".kept")]] std::atomic<int> reporting;

// The report on the console as it grows, and kept for after the restart.
class Report {
 public:
  Report() : kept_(kept.report, sizeof kept.report) {}
  // Writes the line and empties it.
  void line(TextWriter& text) {
    text.put('\n');
    console_write(text.c_str());
    kept_.put(text.c_str());
    text.clear();
  }

 private:
  TextWriter kept_;
};

void put_registers(Report& report, const ExceptionFrame& frame) {
  Text<128> text;
  text.put("  pc ").hex(frame.pc, 16).put("  lr ").hex(frame.x[30], 16);
  text.put("  sp ").hex(frame.sp, 16);
  report.line(text);
  for (int i = 0; i < 30; ++i) {
    text.put(i < 10 ? "  x" : " x").number(i).put(' ').hex(frame.x[i], 16);
    if (i % 4 == 3 || i == 29) report.line(text);
  }
}

// The chain of frame pointers, as far as it stays on this core's stack.
void put_callers(Report& report, uint64_t pc, uint64_t frame_pointer) {
  const AddressRange stack = stack_of(this_core());
  const AddressRange code = {reinterpret_cast<uintptr_t>(__image_begin),
                             reinterpret_cast<uintptr_t>(__text_end)};
  Text<96> text;
  text.put("  called from, innermost first:");
  report.line(text);
  uint64_t last = stack.begin, last_pc = 0;
  for (int lines = 0; lines < kCallersMax && code.holds(pc);) {
    if (pc != last_pc) {  // a recursion is told once
      text.put("    at ").hex(pc, 16);
      report.line(text);
      ++lines;
    }
    last_pc = pc;
    if (frame_pointer % 8 != 0 || frame_pointer < last || frame_pointer + 16 > stack.end) return;
    const auto* const link = reinterpret_cast<const uint64_t*>(frame_pointer);
    last = frame_pointer + 16;
    frame_pointer = link[0];
    pc = link[1] - 4;  // the call, not what follows it
  }
}

void stop_this_core(uint32_t, const ExceptionFrame&) { firmware_core_off(); }

void stop_other_cores() {
  interrupt_all_others(kStopMessage);
  const TimeNs end = now() + kStopping_ns;
  for (int i = 0; i < kMachine.cores; ++i) {
    if (i == this_core()) continue;
    while (!firmware_core_is_off(kMachine.mpidr[i]) && now() < end) {
    }
  }
}

// The image starts again on core 0, all others off.
[[noreturn]] void restart() {
  ++kept.restarts;
  stop_other_cores();
  if (this_core() == 0) bare_restart();
  const auto entry = reinterpret_cast<uintptr_t>(&bare_core_start);
  const Status started = firmware_core_on(kMachine.mpidr[0], entry, kRestart);
  // A core 0 that does not even stop any more takes the whole chip's reset.
  if (started != Status::kOk) firmware_reset();
  firmware_core_off();
}

// One report at a time: a second core that faults waits to be switched off.
void take_the_report() {
  mask_interrupts();
  int nobody = 0;
  const int me = this_core() + 1;
  if (reporting.compare_exchange_strong(nobody, me)) return;
  if (nobody != me) firmware_core_off();
  console_write("\n*** another fault inside the report\n");
  restart();
}

[[noreturn]] void report_and_restart(const char* what, const ExceptionFrame& frame,
                                     bool has_registers) {
  take_the_report();
  Report report;
  Text<160> text;
  text.put("\n*** fault: ").put(what);
  report.line(text);
  const char* const task = watchdog_task(this_core());
  text.put("  core ").number(this_core()).put(", task ").put(task != nullptr ? task : "none");
  text.put(", ").fixed(to_seconds(now()), 6).put(" s after start");
  report.line(text);
  if (has_registers) put_registers(report, frame);
  put_callers(report, frame.pc, frame.x[29]);
  restart();
}

}  // namespace

void fault(const char* what, const ExceptionFrame& frame) { report_and_restart(what, frame, true); }

void fault_here(const char* what) {
  ExceptionFrame frame{};
  const auto* const link = static_cast<const uint64_t*>(__builtin_frame_address(0));
  frame.x[29] = link[0];
  frame.pc = link[1] - 4;
  report_and_restart(what, frame, false);
}

void fault_start(bool restarted) {
  restarted_once = restarted;
  if (!restarted) kept = KeptFault{};
  reporting.store(0);
  const Status handled = interrupt_handle(kStopMessage, stop_this_core);
  PIRVS_ASSERT(handled == Status::kOk);
}

const KeptFault* kept_fault() { return restarted_once ? &kept : nullptr; }

}  // namespace pirvs::bsp

extern "C" void exception_entry(uint64_t kind, const pirvs::bsp::ExceptionFrame* frame);
extern "C" void exception_entry(uint64_t kind, const pirvs::bsp::ExceptionFrame* frame) {
  using namespace pirvs;
  using namespace pirvs::bsp;
  if (kind == static_cast<uint64_t>(ExceptionKind::kInterrupt)) {
    interrupt_entry(*frame);
    return;
  }
  Text<160> what;
  for (int core = 0; core < kMachine.cores; ++core) {
    if (!guard_of(core).holds(frame->address) || !is_data_abort(frame->syndrome)) continue;
    what.put("stack overflow: core ").number(core).put(" has used its ");
    what.unsigned_number(stack_of(core).size() >> 10).put(" KiB; ");
  }
  if (kind >= kInHandler) what.put("in a handler: ");
  put_syndrome(what, kind % kInHandler == static_cast<uint64_t>(ExceptionKind::kSystemError),
               frame->syndrome, frame->address);
  fault(what.c_str(), *frame);
}
