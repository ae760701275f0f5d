// Commands as lines of text, and their answers: what a person types, or a host's program writes, on
// the serial line.
// In      LineReader: bytes as they come; a line ends with CR, LF or both. read_request(): a line:
//           stop                   ends the program in order
//           reset                  forgets the map and starts anew
//           record start|stop
//           parameter NAME VALUE   as pirvs params lists them
//           pose                   the newest one, as pose lines have it
//           pose X Y Z YAW [SIGMA] m, degrees: the present pose is that; with SIGMA: a hint where
//                                  in the loaded map it is
//           map save|load [NAME]   letters, digits and . _ - in the folder of records; map.bin
//           node set NAME [X Y Z YAW], node get|remove NAME: named places of the map
//           counters               all that are not zero
//           poses on|off           pose lines between the answers
//           help
// Out     One line for each that is not empty: `ok` or `error`, the command, what there is to say.
//         Commands that the stack executes are answered when that is done, in order.
// Errors  A line that is too long, holds what is no text, or is no command: `error` and why. But
//         nothing to what begins as our own lines do: a host whose terminal echoes sends each of
//         them back, and would send back the answer, too.
// Cost    microseconds a line. No heap.
// Source  docs/device.md, "Commands".
#pragma once

#include <string_view>

#include "core/base/text.h"
#include "modules/door/command.h"

namespace pirvs::board {

class LineReader {
 public:
  static constexpr size_t kLineMax = 160;

  enum class Taken : uint8_t { kMore, kLine, kBad };
  // kLine: line() holds until the next call. kBad: the line that ends here cannot be read, line()
  // is what could be.
  Taken take(char c);
  std::string_view line() const { return {text_, size_}; }
  void clear() { *this = LineReader{}; }

 private:
  char text_[kLineMax];
  size_t size_ = 0;
  bool ended_ = false, bad_ = false;
};

enum class RequestKind : uint8_t { kNone, kBad, kCommand, kPose, kCounters, kPoses, kHelp };

struct TextRequest {
  RequestKind kind = RequestKind::kNone;
  Command command;            // kCommand
  bool on = false;            // kPoses
  const char* why = nullptr;  // kBad
};

TextRequest read_request(std::string_view line);
// It begins as a pose or an answer does: kNone to read_request.
bool is_echo(std::string_view line);

// Without the end of the line.
void put_answer(TextWriter& out, const Answer& answer);
void put_error(TextWriter& out, const char* why);
void put_help(TextWriter& out);

}  // namespace pirvs::board
