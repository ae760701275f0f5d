// Poses and commands by a serial line, as text: /dev/ttyGS0 of the USB gadget, or a UART. It may
// come and go.
// In      The tty's path; pose(): a line of pose_output.h; answer(): the stack's to a command;
//         poll(): often, whatever it costs the line to say is read there. All from one core.
// Out     Lines: poses as they come, and one for each command (text_commands.h).
// Errors  Nothing waits for the other side. A line for which there is no room is dropped whole and
//         counted; a line that has begun is ended before another one begins. A tty that is gone is
//         looked for again every kRetry_ns.
// Cost    A system call a line, and one every kRead_ns to see what was typed. No heap.
// Source  Linux, drivers/usb/gadget/function/u_serial.c: unplugged, its tty hangs up.
#pragma once

#include "board/linux/text_commands.h"
#include "core/base/counter.h"
#include "core/base/time.h"

namespace pirvs::board {

struct SerialLinkCounters {
  Counter lines, dropped, opened, commands, garbled;
};
inline constexpr CounterRow<SerialLinkCounters> kSerialLinkRows[] = {
    {"lines", &SerialLinkCounters::lines},
    {"dropped", &SerialLinkCounters::dropped},    // the other side does not read
    {"opened", &SerialLinkCounters::opened},      // it came
    {"commands", &SerialLinkCounters::commands},  // lines that were understood
    {"garbled", &SerialLinkCounters::garbled},    // lines that were not
};
static_assert(every_counter_is_in(kSerialLinkRows));

// Who obeys.
struct SerialStack {
  void* context = nullptr;
  Result<uint32_t> (*command)(void*, const Command&) = nullptr;  // the answer's ticket
  void (*put_counters)(void*, TextWriter&) = nullptr;            // ` name=value` each
};

class SerialLink {
 public:
  static constexpr TimeNs kRetry_ns = 500'000'000, kRead_ns = 10'000'000;

  void configure(const char* path, const SerialStack& stack);
  void pose(const TextWriter& line);
  void answer(const Answer& answer);
  void poll(TimeNs now);
  void close();

  bool wanted() const { return path_[0] != 0; }
  const SerialLinkCounters& counters() const { return counters_; }

 private:
  static constexpr size_t kAnswerMax = 8192;  // all counters
  static constexpr int kTicketsMax = 16;      // commands that wait in the inbox

  bool open();
  void read_lines();
  void obey(std::string_view line);
  void obey(const TextRequest& request);
  void command(const Command& command);
  void flush();
  void write_line(const TextWriter& line, bool may_wait);
  size_t write_some(const char* data, size_t size);
  void say(TextWriter& line);

  const char* path_ = "";
  SerialStack stack_;
  int fd_ = -1;
  bool poses_ = true;
  TimeNs retry_t_ = 0, read_t_ = 0;
  LineReader reader_;
  Text<256> newest_;          // pose
  Text<kAnswerMax> answer_;   // in the making
  Text<kAnswerMax> waiting_;  // ends of lines, and answers, for which there was no room
  size_t waiting_from_ = 0;
  uint32_t tickets_[kTicketsMax] = {};  // of commands from here; +1, 0: free
  SerialLinkCounters counters_;
};

}  // namespace pirvs::board
