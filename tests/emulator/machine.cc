#include "tests/emulator/machine.h"

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

MachineRun run_machine(const std::string& board, const std::string& pack,
                       const std::string& words) {
  const char* const build = std::getenv("PIRVS_BUILD");
  const std::string image = std::string(build ? build : "build") + "/" + board + "/pirvs.bin";
  const std::string out = scratch_folder(board);
  const std::string recording = pack.empty() ? "" : " --recording " + pack;
  const std::string command = "tools/emulator/run --image " + image + " --out " + out +
                              recording + " --timeout " + std::to_string(kRun_s_max) + " " +
                              words + " > /dev/null";
  const int status = std::system(command.c_str());  // NOLINT(cert-env33-c): a test, with its own words
  MachineRun run;
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  run.console = read(out + "/console.txt");
  run.trajectory = read(out + "/trajectory.tum");
  run.timing = read(out + "/timing.csv");
  return run;
}

}  // namespace pirvs::systems
