// `pirvs convert SEQ OUT`: a recording in another form.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "tools/cli/command.h"
#include "tools/cli/progress.h"
#include "tools/convert/writers.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/pack_file.h"
#include "tools/dataset/recording_options.h"

namespace pirvs::tools {
namespace {

struct Options {
  std::string sequence, out;
  RecordingOptions recording;
};

int convert(const Options& o) {
  const std::string extension = std::filesystem::path(o.out).extension().string();
  for (const char* other : {".bag", ".db3", ".zip", ".mp4"}) {
    if (extension == other) {
      throw InputError("no form that is written", o.out,
                       "name a file *.mcap or *.pack, or a folder for ASL");
    }
  }
  const Recording recording = open_recording(o.sequence, o.recording);
  print_notes(recording);
  InputLog log;
  if (!recording.order.empty()) log.note("the order in which all came (order.csv) is left out");
  Progress progress("converting", recording.frames.size());
  const auto done = [&progress](size_t frames) { progress.update(frames); };
  if (extension == ".mcap") {
    write_mcap(recording, o.out, done, log);
  } else if (extension == ".pack") {
    write_pack(recording, o.out, [&](size_t frames, size_t) { done(frames); });
    if (!recording.truth.poses.empty()) log.note("the truth is left out of a pack");
  } else {
    write_asl(recording, o.out, done, log);
  }
  print_notes(log);
  for (const Count& count : log.rejected) {
    std::fprintf(stderr, "pirvs: %s: %zu\n", count.name.c_str(), count.value);
  }
  std::printf("%s: %zu frames, %zu IMU samples, %zu poses of the truth, %.1f s\n", o.out.c_str(),
              recording.frames.size(), recording.imu.size(), recording.truth.poses.size(),
              recording.duration_s());
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("SEQ", o->sequence, "a recording, as for run")->required();
  app.add_option("OUT", o->out, "*.mcap, *.pack, or else a folder: ASL")->required();
  add_recording_options(app, o->recording);
  app.footer("*.mcap has the calibration beside it, as *.cfg, where it is found by that name.");
  return [o] { return convert(*o); };
}

}  // namespace

const Command kConvertCommand = {"convert", "Write a recording in another form", declare};

}  // namespace pirvs::tools
