// Runs a board's image in the emulator.
// In      The board, a packed recording, words for the image's command line. PIRVS_BUILD: where
//         `make BOARD=... all` has left the images (default: build).
// Out     Exit status, what the console said, what the image wrote (*.tum, timing.csv).
//         pack_of: the first seconds of the real clip where it is, else of a simulated flight,
//         packed; short_pack: 1.4 s of it, packed once. run_tool: any program, its console only.
// Errors  status 124: it did not end within kRun_s_max.
// Cost    ~0.4 s, and 30 ms a stereo frame.
// Source  tools/emulator/run.
#pragma once

#include <string>

namespace pirvs::systems {

inline constexpr int kRun_s_max = 120;  // on a machine that others load, too

struct MachineRun {
  int status = -1;
  std::string console;     // with function and line behind each address of a report
  std::string line;        // its bytes as they came
  std::string trajectory;  // empty: not written
  std::string fused;       // likewise
  std::string timing;

  bool says(const std::string& text) const { return console.find(text) != std::string::npos; }
};

MachineRun run_machine(const std::string& board, const std::string& pack, const std::string& words);
MachineRun run_tool(const std::string& command);
std::string image_of(const std::string& board);

std::string pack_of(double duration_s);
const std::string& short_pack();

}  // namespace pirvs::systems
