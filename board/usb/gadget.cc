#include "board/usb/gadget.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <iterator>

#include "core/base/text.h"

namespace pirvs::board {
namespace {

constexpr const char* kGadget = "usb_gadget/pirvs";
constexpr size_t kPathMax = 256;

enum class Kind : uint8_t { kFolder, kText, kLink, kGuid, kUdc };
enum class Part : uint8_t { kAll, kVideo };

struct Value {
  char text[64];
};
// What is not the same for all devices.
struct Values {
  Value serial, own_mac, host_mac, width, height, bytes, bits_a_second, interval, udc;
};

// "Y800" as a GUID: 8-bit grey.
constexpr uint8_t kGreyGuid[] = {'Y',  '8',  '0',  '0',  0x00, 0x00, 0x10, 0x00,
                                 0x80, 0x00, 0x00, 0xaa, 0x00, 0x38, 0x9b, 0x71};

struct Row {
  Kind kind;
  Part part;
  const char* name;               // "": the gadget's own folder
  const char* text = nullptr;     // the attribute's, or what a link shows
  Value Values::*made = nullptr;  // instead of it
};
#define PIRVS_UVC "/functions/uvc.0"
#define PIRVS_GREY PIRVS_UVC "/streaming/uncompressed/grey"
constexpr Row kRows[] = {
    {Kind::kFolder, Part::kAll, ""},
    // Linux Foundation, Multifunction Composite Gadget: hosts know it by its interfaces alone.
    {Kind::kText, Part::kAll, "/idVendor", "0x1d6b"},
    {Kind::kText, Part::kAll, "/idProduct", "0x0104"},
    {Kind::kText, Part::kAll, "/bcdUSB", "0x0200"},
    // Functions of more than one interface, by association.
    {Kind::kText, Part::kAll, "/bDeviceClass", "0xef"},
    {Kind::kText, Part::kAll, "/bDeviceSubClass", "0x02"},
    {Kind::kText, Part::kAll, "/bDeviceProtocol", "0x01"},
    {Kind::kFolder, Part::kAll, "/strings/0x409"},
    {Kind::kText, Part::kAll, "/strings/0x409/manufacturer", "PIRVS"},
    {Kind::kText, Part::kAll, "/strings/0x409/product", "PIRVS visual-inertial SLAM"},
    {Kind::kText, Part::kAll, "/strings/0x409/serialnumber", nullptr, &Values::serial},
    {Kind::kFolder, Part::kAll, "/configs/c.1"},
    {Kind::kText, Part::kAll, "/configs/c.1/MaxPower", "500"},
    {Kind::kFolder, Part::kAll, "/configs/c.1/strings/0x409"},
    {Kind::kText, Part::kAll, "/configs/c.1/strings/0x409/configuration", "NCM, ACM, UVC"},
    {Kind::kFolder, Part::kAll, "/functions/ncm.0"},
    {Kind::kText, Part::kAll, "/functions/ncm.0/dev_addr", nullptr, &Values::own_mac},
    {Kind::kText, Part::kAll, "/functions/ncm.0/host_addr", nullptr, &Values::host_mac},
    {Kind::kLink, Part::kAll, "/configs/c.1/ncm.0", "/functions/ncm.0"},
    {Kind::kFolder, Part::kAll, "/functions/acm.0"},
    {Kind::kLink, Part::kAll, "/configs/c.1/acm.0", "/functions/acm.0"},
    // The camera, last: without it the numbers of the other interfaces stay.
    {Kind::kFolder, Part::kVideo, PIRVS_UVC},
    {Kind::kText, Part::kVideo, PIRVS_UVC "/streaming_maxpacket", "3072"},  // 24 MB/s, high speed
    {Kind::kFolder, Part::kVideo, PIRVS_UVC "/control/header/h"},
    {Kind::kLink, Part::kVideo, PIRVS_UVC "/control/class/fs/h", PIRVS_UVC "/control/header/h"},
    {Kind::kLink, Part::kVideo, PIRVS_UVC "/control/class/ss/h", PIRVS_UVC "/control/header/h"},
    {Kind::kFolder, Part::kVideo, PIRVS_GREY},
    {Kind::kGuid, Part::kVideo, PIRVS_GREY "/guidFormat"},
    {Kind::kText, Part::kVideo, PIRVS_GREY "/bBitsPerPixel", "8"},
    {Kind::kFolder, Part::kVideo, PIRVS_GREY "/frame"},
    {Kind::kText, Part::kVideo, PIRVS_GREY "/frame/wWidth", nullptr, &Values::width},
    {Kind::kText, Part::kVideo, PIRVS_GREY "/frame/wHeight", nullptr, &Values::height},
    {Kind::kText, Part::kVideo, PIRVS_GREY "/frame/dwMaxVideoFrameBufferSize", nullptr,
     &Values::bytes},
    {Kind::kText, Part::kVideo, PIRVS_GREY "/frame/dwMinBitRate", nullptr, &Values::bits_a_second},
    {Kind::kText, Part::kVideo, PIRVS_GREY "/frame/dwMaxBitRate", nullptr, &Values::bits_a_second},
    {Kind::kText, Part::kVideo, PIRVS_GREY "/frame/dwDefaultFrameInterval", nullptr,
     &Values::interval},
    {Kind::kText, Part::kVideo, PIRVS_GREY "/frame/dwFrameInterval", nullptr, &Values::interval},
    {Kind::kFolder, Part::kVideo, PIRVS_UVC "/streaming/header/h"},
    {Kind::kLink, Part::kVideo, PIRVS_UVC "/streaming/header/h/grey", PIRVS_GREY},
    {Kind::kLink, Part::kVideo, PIRVS_UVC "/streaming/class/fs/h", PIRVS_UVC "/streaming/header/h"},
    {Kind::kLink, Part::kVideo, PIRVS_UVC "/streaming/class/hs/h", PIRVS_UVC "/streaming/header/h"},
    {Kind::kLink, Part::kVideo, PIRVS_UVC "/streaming/class/ss/h", PIRVS_UVC "/streaming/header/h"},
    {Kind::kLink, Part::kVideo, "/configs/c.1/uvc.0", PIRVS_UVC},
    {Kind::kUdc, Part::kAll, "/UDC", nullptr, &Values::udc},
};
#undef PIRVS_GREY
#undef PIRVS_UVC

uint64_t digest(const char* text) {
  constexpr uint64_t kFnvBasis = 0xcbf29ce484222325, kFnvPrime = 0x100000001b3;
  uint64_t hash = kFnvBasis;
  for (; *text != 0; ++text) hash = (hash ^ static_cast<uint8_t>(*text)) * kFnvPrime;
  return hash;
}

void put_hex(uint64_t value, int digits, char*& out) {
  for (int i = digits - 1; i >= 0; --i) *out++ = "0123456789abcdef"[value >> 4 * i & 15];
}

void put(Value& out, const char* text) { TextWriter(out.text, sizeof out.text).put(text); }
void put(Value& out, uint64_t number) {
  TextWriter(out.text, sizeof out.text).unsigned_number(number);
}

Values values_of(const GadgetSetup& setup) {
  constexpr double kUnits_s = 1e7;  // of an interval
  Values out{};
  const UsbSettings& usb = setup.usb;
  const auto bytes = static_cast<uint64_t>(usb.width) * static_cast<uint64_t>(usb.height);
  put(out.serial, setup.serial);
  put(out.own_mac, mac_address(setup.serial, false).text);
  put(out.host_mac, mac_address(setup.serial, true).text);
  put(out.width, static_cast<uint64_t>(usb.width));
  put(out.height, static_cast<uint64_t>(usb.height));
  put(out.bytes, bytes);
  put(out.bits_a_second, static_cast<uint64_t>(8.0 * static_cast<double>(bytes) * usb.rate_hz));
  put(out.interval, static_cast<uint64_t>(kUnits_s / usb.rate_hz));
  put(out.udc, setup.udc);
  return out;
}

struct Path : Text<kPathMax> {
  Path(const char* configfs, const char* name) {
    put(configfs).put('/').put(kGadget).put(name);
    PIRVS_ASSERT(!full());
  }
};

int make_folder(const char* path) { return mkdir(path, 0755); }

int write_file(const char* path, const void* data, size_t size) {
  const int fd = open(path, O_WRONLY | O_CLOEXEC);
  if (fd < 0) return -1;
  const bool whole = write(fd, data, size) == static_cast<ssize_t>(size);
  const int error = errno;
  close(fd);
  errno = error;
  return whole ? 0 : -1;
}

}  // namespace

const FolderCalls kFolderCalls = {make_folder, rmdir, symlink, unlink, write_file};

MacAddress mac_address(const char* serial, bool host) {
  constexpr uint64_t kLocal = 0x02, kEnds = 1;
  uint64_t bytes = digest(serial) & 0xffff'ffff'ffff;
  bytes = (bytes & ~(0xffull << 40)) | kLocal << 40;
  bytes = (bytes & ~kEnds) | static_cast<uint64_t>(host);
  MacAddress out{};
  char* at = out.text;
  for (int byte = 5; byte >= 0; --byte) {
    put_hex(bytes >> 8 * byte & 0xff, 2, at);
    *at++ = byte > 0 ? ':' : 0;
  }
  return out;
}

void put_digest(const char* text, char* out) {
  put_hex(digest(text), 16, out);
  *out = 0;
}

namespace {

bool make_row(const char* configfs, const FolderCalls& calls, const Row& row, const char* text) {
  const Path path(configfs, row.name);
  switch (row.kind) {
    case Kind::kFolder:
      return calls.make_folder(path.c_str()) == 0;
    case Kind::kLink:
      return calls.make_link(Path(configfs, text).c_str(), path.c_str()) == 0;
    case Kind::kGuid:
      return calls.write_file(path.c_str(), kGreyGuid, sizeof kGreyGuid) == 0;
    case Kind::kText:
    case Kind::kUdc:
      return calls.write_file(path.c_str(), text, std::strlen(text)) == 0;
  }
  return false;
}

// What it holds of its own, attributes and folders, goes with each folder.
void remove_row(const char* configfs, const FolderCalls& calls, const Row& row) {
  const Path path(configfs, row.name);
  if (row.kind == Kind::kUdc) (void)calls.write_file(path.c_str(), "\n", 1);
  if (row.kind == Kind::kLink) (void)calls.remove_link(path.c_str());
  if (row.kind == Kind::kFolder) (void)calls.remove_folder(path.c_str());
}

}  // namespace

const char* Gadget::make(const GadgetSetup& setup) const {
  const Values values = values_of(setup);
  for (const Row& row : kRows) {
    if (row.part == Part::kVideo && setup.usb.video == UsbVideo::kNone) continue;
    const char* const text = row.made != nullptr ? (values.*row.made).text : row.text;
    if (make_row(configfs_, *calls_, row, text)) continue;
    const int error = errno;
    remove();
    errno = error;
    return row.name;
  }
  return nullptr;
}

void Gadget::remove() const {
  for (size_t i = std::size(kRows); i-- > 0;) remove_row(configfs_, *calls_, kRows[i]);
}

}  // namespace pirvs::board
