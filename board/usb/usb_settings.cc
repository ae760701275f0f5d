#include "board/usb/usb_settings.h"

#include <cstring>

namespace pirvs::board {
namespace {

constexpr std::string_view kUsb = "usb.";

const char* read_video(std::string_view value, UsbSettings& out) {
  constexpr struct {
    const char* word;
    UsbVideo video;
  } kVideos[] = {{"left", UsbVideo::kLeft}, {"right", UsbVideo::kRight}, {"none", UsbVideo::kNone}};
  for (const auto& row : kVideos) {
    if (value != row.word) continue;
    out.video = row.video;
    return nullptr;
  }
  return "left, right or none";
}

// A frame's size goes to the host in sixteen bits a side.
const char* read_size(std::string_view value, UsbSettings& out) {
  constexpr int64_t kMin = 16, kMax = 4096;
  std::string_view words[2];
  int64_t size[2];
  if (!read_words(value, words, 2) || !read_whole(words[0], kMin, kMax, size[0]) ||
      !read_whole(words[1], kMin, kMax, size[1])) {
    return "not a size in pixels, as 640 480";
  }
  out.width = static_cast<int>(size[0]);
  out.height = static_cast<int>(size[1]);
  return nullptr;
}

const char* read_rate(std::string_view value, UsbSettings& out) {
  double rate_hz = 0;
  if (!read_numbers(value, &rate_hz, 1) || rate_hz < 1 || rate_hz > 240) {
    return "not a rate from 1 to 240 Hz";
  }
  out.rate_hz = rate_hz;
  return nullptr;
}

const char* read_serial(std::string_view value, UsbSettings& out) {
  if (value.size() > UsbSettings::kSerialMax) return "longer than 32 letters";
  for (const char c : value) {
    const bool good = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    if (!good) return "letters and digits alone";
  }
  std::memcpy(out.serial, value.data(), value.size());
  out.serial[value.size()] = 0;
  return nullptr;
}

// A Unix socket's address holds 107 bytes.
const char* read_images(std::string_view value, UsbSettings& out) {
  if (value.size() >= sizeof out.images) return "longer than 95 bytes";
  std::memcpy(out.images, value.data(), value.size());
  out.images[value.size()] = 0;
  return nullptr;
}

struct Key {
  const char* name;
  const char* (*read)(std::string_view, UsbSettings&);
};
constexpr Key kKeys[] = {{"usb.video", read_video},
                         {"usb.size", read_size},
                         {"usb.rate_hz", read_rate},
                         {"usb.serial", read_serial},
                         {"output.images", read_images}};

}  // namespace

bool is_usb_key(std::string_view key) { return !behind(key, kUsb).empty(); }

const char* set_usb_setting(UsbSettings& settings, std::string_view key, std::string_view value) {
  for (const Key& known : kKeys) {
    if (key == known.name) return known.read(value, settings);
  }
  return "no such key";
}

ConfigFault read_usb_settings(std::string_view text, UsbSettings& out) {
  KeyValues lines(text);
  KeyValue line;
  Status status = Status::kOk;
  while ((status = lines.next(line)) == Status::kOk) {
    if (!is_usb_key(line.key) && line.key != "output.images") continue;
    const char* const what = set_usb_setting(out, line.key, line.value);
    if (what != nullptr) return {line.line, what, line.key};
  }
  return status == Status::kBadData ? lines.fault() : ConfigFault{};
}

}  // namespace pirvs::board
