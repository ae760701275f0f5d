#include "board/linux/recordings.h"

#include <sys/stat.h>

#include <cstring>

#include "bsp/api/console.h"
#include "bsp/linux/numbered_folder.h"
#include "bsp/linux/storage.h"

namespace pirvs::board {

const char* Recordings::start(const Settings& settings, App& app) {
  const char* const folder = folder_ = folder_of(settings);
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

Result<const char*> Recordings::next() {
  const Status status = bsp::make_numbered_folder(folder_, name_);
  Text<160> line;
  line.put("pirvsd: ").put(folder_).put(status == Status::kOk ? ": recording " : ": no new folder");
  if (status == Status::kOk) line.put(name_.c_str());
  line.put('\n');
  bsp::console_write(line.c_str());
  if (status != Status::kOk) return status;
  name_.put('/');
  return name_.c_str();
}

void Recordings::answer(const Answer& answer) {
  const bool recording = answer.kind == CommandKind::kStartRecording;
  if (recording && answer.status == Status::kOk) disk_sync_.begin();
}

}  // namespace pirvs::board
