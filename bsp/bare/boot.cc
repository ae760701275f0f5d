#include "bsp/bare/boot.h"

#include "bsp/api/console.h"
#include "bsp/bare/core_setup.h"
#include "bsp/bare/fault.h"
#include "bsp/bare/firmware.h"
#include "bsp/bare/interrupts.h"
#include "bsp/bare/machine.h"
#include "bsp/bare/semihosting.h"
#include "bsp/bare/stacks.h"
#include "bsp/drivers/device_tree/device_tree.h"
#include "core/base/assert.h"
#include "core/base/text.h"

extern "C" {
extern uint64_t boot_registers[2];  // start.S: device tree, CurrentEL
extern uint64_t bare_level2[];      // start.S: the page tables, a word per 2 MiB
extern char __image_begin[], __image_end[], __pools_begin[], __pools_end[];
extern void (*__init_array_begin[])();
extern void (*__init_array_end[])();
}

namespace pirvs::bsp {
namespace {

constexpr uint64_t kBlock = 2u << 20;
constexpr uint64_t kMapped = uint64_t{4} << 30;  // what the page tables reach
// UXN, PXN, AF, inner shareable, read-only, write-back memory, a block (arch.h, BLOCK_READ_ONLY).
constexpr uint64_t kReadOnlyBlock = uint64_t{3} << 53 | 1u << 10 | 3u << 8 | 1u << 7 | 1u << 2 | 1;

DeviceTree device_tree;

bool overlaps(uint64_t begin, uint64_t end, const char* mine_begin, const char* mine_end) {
  return begin < reinterpret_cast<uint64_t>(mine_end) &&
         reinterpret_cast<uint64_t>(mine_begin) < end;
}

bool is_free(uint64_t begin, uint64_t end) {
  return end <= kMapped && !overlaps(begin, end, __image_begin, __image_end) &&
         !overlaps(begin, end, __pools_begin, __pools_end);
}

// From "not mapped" to mapped: no stale translation has to be thrown out.
void map_read_only(uint64_t begin, uint64_t end) {
  for (uint64_t block = begin / kBlock; block * kBlock < end; ++block) {
    if (bare_level2[block] == 0) bare_level2[block] = block * kBlock | kReadOnlyBlock;
  }
  asm volatile("dsb ish\n isb" ::: "memory");
}

void find_device_tree() {
  uint64_t address = boot_registers[0];
  if (address == 0) {
    address = kMachine.device_tree;
    if (address == 0) return;
    map_read_only(address, address + kDeviceTreeMax);
  }
  if (!is_free(address, address + 8)) fault_here("the device tree overlaps the image or pools");
  (void)read_device_tree(reinterpret_cast<const void*>(address), device_tree);
}

void find_recording() {
  const uint64_t begin = device_tree.initrd_begin, end = device_tree.initrd_end;
  if (end <= begin) return;
  if (!is_free(begin, end))
    fault_here("the recording overlaps the image or pools, or lies too high");
  map_read_only(begin, end);
}

}  // namespace

bool boot_argument(const char* name, char* value, size_t size) {
  return find_argument(device_tree.arguments, name, value, size);
}

bool boot_argument(const char* name) {
  char ignored[1];
  return boot_argument(name, ignored, sizeof ignored);
}

Memory boot_recording() {
  if (device_tree.initrd_end <= device_tree.initrd_begin) return {};
  return {reinterpret_cast<const void*>(device_tree.initrd_begin),
          device_tree.initrd_end - device_tree.initrd_begin};
}

void machine_exit(int code) {
  if (boot_argument("semihosting")) semihosting_exit(code);
  Text<64> text;
  text.put("done, status ").number(code).put('\n');
  console_write(text.c_str());
  for (;;) asm volatile("wfi");
}

void safe_state() {
  const KeptFault& fault = *kept_fault();
  Text<128> text;
  text.put("\n*** restart ").unsigned_number(fault.restarts).put(" of ");
  text.put(kMachine.name).put(", safe state: no task runs. Why:\n");
  console_write(text.c_str());
  console_write(fault.report);
  if (boot_argument("semihosting")) semihosting_exit(kExitSafeState);
  if (fault.restarts > kRestartsMax) {
    console_write("*** too many restarts; standing still\n");
    for (;;) asm volatile("wfi");
  }
  console_write("*** any key: the report again; R: reset\n");
  for (;;) {
    const int key = kMachine.uart_read();
    if (key == 'R') firmware_reset();
    if (key >= 0) console_write(fault.report);
  }
}

}  // namespace pirvs::bsp

extern "C" void bare_main(uint64_t restarted);
extern "C" void bare_main(uint64_t restarted) {
  using namespace pirvs::bsp;
  kMachine.uart_start();
  for (auto* init = __init_array_begin; init < __init_array_end; ++init) (*init)();
  stacks_paint();
  interrupts_start();
  fault_start(restarted != 0);
  find_device_tree();
  firmware_start(device_tree.firmware);
  find_recording();
  watchdog_start();
  start_this_core();
  if (restarted != 0) safe_state();
  machine_exit(pirvs::application());
}
