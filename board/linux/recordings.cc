#include "board/linux/recordings.h"

#include <sys/stat.h>

#include <cstring>

#include "bsp/linux/storage.h"

namespace pirvs::board {

const char* Recordings::start(const Settings& settings, App& app) {
  const char* const folder = folder_of(settings);
  const bool at_once = settings.record.text[0] != 0;
  if (std::strcmp(folder, ".") != 0) {
    (void)mkdir(folder, 0755);  // app.record() tells when this was in vain, or a command's answer
    bsp::set_storage_directory(folder);
  }
  if (at_once || settings.serial.text[0] != 0) (void)disk_sync_.start(folder);
  if (!at_once) return nullptr;
  if (app.record() != Status::kOk) return "cannot record there";
  disk_sync_.begin();
  return nullptr;
}

void Recordings::answer(const Answer& answer) {
  const bool recording = answer.kind == CommandKind::kStartRecording;
  if (recording && answer.status == Status::kOk) disk_sync_.begin();
}

}  // namespace pirvs::board
