#include "tests/emulator/machine.h"

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/recordings.h"
#include "tools/dataset/pack_file.h"

namespace pirvs::systems {
namespace {

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

int run_shell(const std::string& command) {
  const int status =
      std::system(command.c_str());  // NOLINT(cert-env33-c): a test, with its own words
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

std::string image_of(const std::string& board) {
  const char* const build = std::getenv("PIRVS_BUILD");
  return std::string(build ? build : "build") + "/" + board + "/pirvs.bin";
}

MachineRun run_tool(const std::string& command) {
  const std::string console = scratch_folder("tool") + "/console.txt";
  MachineRun run;
  run.status = run_shell(command + " > " + console + " 2>&1");
  run.console = read(console);
  return run;
}

std::string pack_of(double duration_s) {
  const std::string folder = scratch_folder("pack" + std::to_string(int(duration_s * 10)));
  tools::RecordingOptions options;
  options.duration_s = duration_s;
  const tools::Recording* const real = clip();
  const std::string source = real ? real->folder : simulated(SimulatedDevice::kEuroc).folder;
  tools::write_pack(tools::open_recording(source, options), folder + "/recording.pack",
                    [](size_t, size_t) {});
  return folder + "/recording.pack";
}

const std::string& short_pack() {
  static const std::string pack = pack_of(1.4);
  return pack;
}

MachineRun run_machine(const std::string& board, const std::string& pack,
                       const std::string& words) {
  const std::string out = scratch_folder(board);
  const std::string recording = pack.empty() ? "" : " --recording " + pack;
  const std::string command = "tools/emulator/run --image " + image_of(board) + " --out " + out +
                              recording + " --timeout " + std::to_string(kRun_s_max) + " " + words +
                              " > /dev/null";
  MachineRun run;
  run.status = run_shell(command);
  run.console = read(out + "/console.txt");
  run.line = read(out + "/console.bin");
  run.trajectory = read(out + "/trajectory.tum");
  run.fused = read(out + "/fused.tum");
  run.timing = read(out + "/timing.csv");
  return run;
}

}  // namespace pirvs::systems
