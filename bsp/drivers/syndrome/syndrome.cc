#include "bsp/drivers/syndrome/syndrome.h"

namespace pirvs::bsp {
namespace {

enum Class : uint64_t {
  kUnknown = 0x00,
  kIllegalState = 0x0e,
  kInstructionAbort = 0x21,  // from our own level, likewise below
  kPcAlignment = 0x22,
  kDataAbort = 0x25,
  kSpAlignment = 0x26,
  kFloatingPoint = 0x2c,
  kBreakpoint = 0x3c,
};
constexpr uint64_t kNullBytes = 0x10000;  // an access below is one through a null pointer
constexpr uint64_t kWrite = 1u << 6;      // WnR
constexpr uint64_t kFnv = 1u << 10;       // FAR is not valid

uint64_t class_of(uint64_t syndrome) { return syndrome >> 26 & 0x3f; }

const char* why(uint64_t status) {
  switch (status & 0x3c) {  // without the table's level
    case 0x00:
      return "address too large";
    case 0x04:
      return "not mapped";
    case 0x08:
      return "no access flag";
    case 0x0c:
      return "not allowed";
    default:
      break;
  }
  if (status == 0x10) return "nothing answers there";
  if (status == 0x21) return "not aligned";
  return "of another kind";
}

void put_abort(TextWriter& out, const char* access, uint64_t syndrome, uint64_t address) {
  const bool known = (syndrome & kFnv) == 0;
  if (known && address < kNullBytes) out.put("null access: ");
  out.put(access);
  if (known) out.put(" at ").hex(address, 16);
  out.put(", ").put(why(syndrome & 0x3f));
}

}  // namespace

bool is_data_abort(uint64_t syndrome) { return class_of(syndrome) == kDataAbort; }

void put_syndrome(TextWriter& out, bool system_error, uint64_t syndrome, uint64_t address) {
  if (system_error) {
    out.put("system error, syndrome ").hex(syndrome);
    return;
  }
  switch (class_of(syndrome)) {
    case kUnknown:
      out.put("undefined instruction");
      break;
    case kIllegalState:
      out.put("illegal state");
      break;
    case kInstructionAbort:
      put_abort(out, "jump", syndrome, address);
      break;
    case kPcAlignment:
      out.put("jump to an odd address ").hex(address, 16);
      break;
    case kDataAbort:
      put_abort(out, (syndrome & kWrite) != 0 ? "write" : "read", syndrome, address);
      break;
    case kSpAlignment:
      out.put("stack pointer not aligned");
      break;
    case kFloatingPoint:
      out.put("floating-point exception");
      break;
    case kBreakpoint:
      out.put("trap of the compiler, brk ").hex(syndrome & 0xffff);
      break;
    default:
      out.put("exception of class ").hex(class_of(syndrome)).put(", syndrome ").hex(syndrome);
  }
}

}  // namespace pirvs::bsp
