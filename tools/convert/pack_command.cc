// `pirvs pack SEQ --out FILE`: a recording as one file, for boards that find it in their RAM.
#include <cstdio>
#include <memory>

#include "tools/cli/command.h"
#include "tools/cli/progress.h"
#include "tools/dataset/pack_file.h"
#include "tools/dataset/recording_options.h"

namespace pirvs::tools {
namespace {

struct Options {
  std::string sequence;
  std::string out;
  RecordingOptions recording;
};

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("SEQ", o->sequence, "recording: an ASL/EuRoC folder")->required();
  app.add_option("--out", o->out, "the file to write")->required();
  add_recording_options(app, o->recording);
  app.add_option("--gnss", o->recording.gnss,
                 "fixes of a GNSS receiver, instead of the recording's own");
  return [o] {
    const Recording recording = open_recording(o->sequence, o->recording);
    print_notes(recording);
    Progress progress("packing", recording.frames.size());
    const size_t bytes =
        write_pack(recording, o->out, [&](size_t done, size_t) { progress.update(done); });
    std::printf("%s: %zu frames, %zu IMU samples, %zu fixes, %.1f s, %.1f MB\n", o->out.c_str(),
                recording.frames.size(), recording.imu.size(), recording.gnss.size(),
                recording.duration_s(), double(bytes) * 1e-6);
    return kExitDone;
  };
}

}  // namespace

const Command kPackCommand = {"pack", "Pack a recording into one file, for boards without files",
                              declare};

}  // namespace pirvs::tools
