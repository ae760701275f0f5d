#include "board/linux/text_commands.h"

#include <cstring>
#include <iterator>

#include "core/base/number.h"
#include "core/config/key_values.h"
#include "core/math/so3.h"

namespace pirvs::board {
namespace {

constexpr int kWordsMax = 7;  // node set NAME X Y Z YAW
constexpr std::string_view kMap = "map.bin";

struct Words {
  std::string_view at[kWordsMax];
  int count = 0;  // kWordsMax + 1: there are more

  bool are(std::string_view first, std::string_view second) const {
    return count >= 2 && at[0] == first && at[1] == second;
  }
};

Words split(std::string_view line) {
  constexpr std::string_view kBlanks = " \t";
  Words out;
  size_t from = 0;
  while ((from = line.find_first_not_of(kBlanks, from)) != std::string_view::npos) {
    const size_t end = std::min(line.find_first_of(kBlanks, from), line.size());
    if (out.count == kWordsMax) {
      ++out.count;
      break;
    }
    out.at[out.count++] = line.substr(from, end - from);
    from = end;
  }
  return out;
}

TextRequest bad(const char* why) {
  TextRequest out;
  out.kind = RequestKind::kBad;
  out.why = why;
  return out;
}

TextRequest request(RequestKind kind) {
  TextRequest out;
  out.kind = kind;
  return out;
}

TextRequest command(CommandKind kind, std::string_view text = "") {
  TextRequest out = request(RequestKind::kCommand);
  out.command.kind = kind;
  std::memcpy(out.command.text, text.data(), text.size());
  out.command.text[text.size()] = 0;
  return out;
}

// A file of the storage's own folder: a host cannot reach others.
bool is_file_name(std::string_view name) {
  if (name.empty() || name.size() >= Command::kTextMax || name[0] == '.') return false;
  for (const char c : name) {
    const bool good = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                      c == '.' || c == '_' || c == '-';
    if (!good) return false;
  }
  return true;
}

TextRequest read_map(const Words& words) {
  const std::string_view name = words.count == 3 ? words.at[2] : kMap;
  if (words.count > 3 || !is_file_name(name))
    return bad("map save|load NAME: letters, digits, ._-");
  return command(words.at[1] == "save" ? CommandKind::kSaveMap : CommandKind::kLoadMap, name);
}

TextRequest read_parameter(const Words& words) {
  double value = 0;
  if (words.count != 3 || !read_number(words.at[2], value)) return bad("parameter NAME VALUE");
  if (words.at[1].size() >= Command::kTextMax) return bad("no such parameter");
  TextRequest out = command(CommandKind::kSetParameter, words.at[1]);
  out.command.value = static_cast<float>(value);
  return out;
}

// Words X Y Z YAW, m and degrees.
bool read_place(const Words& words, int first, Command& out) {
  constexpr double kDegree_rad = 3.14159265358979323846 / 180;
  double numbers[4];
  for (int i = 0; i < 4; ++i) {
    if (!read_number(words.at[first + i], numbers[i])) return false;
  }
  out.p_WB = Vec3(numbers[0], numbers[1], numbers[2]);
  out.yaw_rad = numbers[3] * kDegree_rad;
  return true;
}

TextRequest read_pose(const Words& words) {
  constexpr const char* kHow = "pose, or pose X Y Z YAW [SIGMA] in m and degrees";
  if (words.count == 1) return request(RequestKind::kPose);
  TextRequest out = command(CommandKind::kSetPose);
  double sigma_m = 0;
  const bool hint = words.count == 6;
  if (hint && (!read_number(words.at[5], sigma_m) || !(sigma_m > 0))) return bad(kHow);
  out.command.value = static_cast<float>(sigma_m);
  if ((words.count == 5 || hint) && read_place(words, 1, out.command)) return out;
  return bad(kHow);
}

TextRequest read_node(const Words& words) {
  constexpr struct {
    std::string_view word;
    CommandKind kind;
  } kDo[] = {{"set", CommandKind::kSetNode},
             {"get", CommandKind::kGetNode},
             {"remove", CommandKind::kRemoveNode}};
  for (const auto& one : kDo) {
    if (words.count < 3 || words.at[1] != one.word || !is_file_name(words.at[2])) continue;
    TextRequest out = command(one.kind, words.at[2]);
    if (words.count == 3) return out;
    const bool placed = one.kind == CommandKind::kSetNode && words.count == 7;
    out.command.value = 1;
    if (placed && read_place(words, 3, out.command)) return out;
  }
  return bad("node set NAME [X Y Z YAW], node get|remove NAME");
}

TextRequest read_poses(const Words& words) {
  if (words.count != 2 || (words.at[1] != "on" && words.at[1] != "off")) return bad("poses on|off");
  TextRequest out = request(RequestKind::kPoses);
  out.on = words.at[1] == "on";
  return out;
}

// Without any more words.
constexpr struct {
  std::string_view first, second;
  TextRequest (*make)();
} kPlain[] = {
    {"stop", {}, [] { return command(CommandKind::kStop); }},
    {"reset", {}, [] { return command(CommandKind::kReset); }},
    {"record", "start", [] { return command(CommandKind::kStartRecording); }},
    {"record", "stop", [] { return command(CommandKind::kStopRecording); }},
    {"counters", {}, [] { return request(RequestKind::kCounters); }},
    {"help", {}, [] { return request(RequestKind::kHelp); }},
};

const char* word(CommandKind kind) {
  static constexpr const char* kWords[] = {"stop",     "reset",    "parameter",    "pose",
                                           "map save", "map load", "record start", "record stop",
                                           "node set", "node get", "node remove"};
  static_assert(std::size(kWords) == static_cast<size_t>(CommandKind::kCount));
  return kWords[static_cast<size_t>(kind)];
}

}  // namespace

// ---- lines -------------------------------------------------------------------------------------

LineReader::Taken LineReader::take(char c) {
  if (ended_) clear();
  if (c == '\r' || c == '\n') {
    ended_ = true;
    return bad_ ? Taken::kBad : Taken::kLine;
  }
  const bool text = (c >= ' ' && c <= '~') || c == '\t';
  if (!text || size_ == kLineMax) bad_ = true;
  if (!bad_) text_[size_++] = c;
  return Taken::kMore;
}

bool is_echo(std::string_view line) {
  const std::string_view first = split(line).at[0];
  const bool number = !first.empty() && (first[0] == '-' || (first[0] >= '0' && first[0] <= '9'));
  return number || first == "ok" || first == "error";
}

TextRequest read_request(std::string_view line) {
  const Words words = split(line);
  if (words.count == 0 || is_echo(line)) return {};
  for (const auto& plain : kPlain) {
    const int count = plain.second.empty() ? 1 : 2;
    const bool same = words.count == count && words.at[0] == plain.first &&
                      (count == 1 || words.at[1] == plain.second);
    if (same) return plain.make();
  }
  if (words.are("map", "save") || words.are("map", "load")) return read_map(words);
  if (words.at[0] == "parameter") return read_parameter(words);
  if (words.at[0] == "node") return read_node(words);
  if (words.at[0] == "pose") return read_pose(words);
  if (words.at[0] == "poses") return read_poses(words);
  return bad("no such command, see help");
}

// ---- answers -----------------------------------------------------------------------------------

void put_answer(TextWriter& out, const Answer& answer) {
  out.put(answer.status == Status::kOk ? "ok " : "error ").put(word(answer.kind));
  if (answer.status != Status::kOk) {
    out.put(": ").put(name(answer.status));
  } else if (answer.kind == CommandKind::kGetNode) {
    const Vec4 q = quat_xyzw(answer.T_WN.R);
    for (int i = 0; i < 3; ++i) out.put(' ').fixed(answer.T_WN.p[i], 6);
    for (int i = 0; i < 4; ++i) out.put(' ').fixed(q[i], 6);
  }
}

void put_error(TextWriter& out, const char* why) { out.put("error ").put(why); }

void put_help(TextWriter& out) {
  out.put("ok help: stop, reset, record start|stop, parameter NAME VALUE, pose, ");
  out.put(
      "pose X Y Z YAW [SIGMA], map save|load [NAME], node set|get|remove NAME, counters, poses "
      "on|off, help");
}

}  // namespace pirvs::board
