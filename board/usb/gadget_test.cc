#include "board/usb/gadget.h"

#include <errno.h>
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace pirvs::board {
namespace {

// Configfs, as far as order matters: what is linked, or has what we have made in it, stays.
struct FakeConfigfs {
  std::set<std::string> folders = {"/cfs/usb_gadget"};
  std::map<std::string, std::string> files, links;
  std::string refuses;  // a path
  std::vector<std::string> refused;

  int refuse(const std::string& path, int error) {
    refused.push_back(path);
    errno = error;
    return -1;
  }
  bool linked(const std::string& path) const {
    for (const auto& link : links) {
      if (link.second == path || link.second.rfind(path + "/", 0) == 0) return true;
    }
    return false;
  }
  bool bound() const {
    const auto udc = files.find("/cfs/usb_gadget/pirvs/UDC");
    return udc != files.end() && udc->second != "\n";
  }
};
FakeConfigfs configfs;  // anew for each test

const FolderCalls kFake = {[](const char* path) {
                             if (configfs.refuses == path) return configfs.refuse(path, ENOENT);
                             if (!configfs.folders.insert(path).second)
                               return configfs.refuse(path, EEXIST);
                             return 0;
                           },
                           [](const char* path) {
                             if (configfs.folders.count(path) == 0) {
                               errno = ENOENT;
                               return -1;
                             }
                             if (configfs.linked(path)) return configfs.refuse(path, EBUSY);
                             const auto next = configfs.folders.upper_bound(path);
                             const bool full = next != configfs.folders.end() &&
                                               next->rfind(std::string(path) + "/", 0) == 0;
                             if (full) return configfs.refuse(path, ENOTEMPTY);
                             configfs.folders.erase(path);
                             return 0;
                           },
                           [](const char* target, const char* path) {
                             if (configfs.folders.count(target) == 0)
                               return configfs.refuse(path, ENOENT);
                             if (!configfs.links.emplace(path, target).second)
                               return configfs.refuse(path, EEXIST);
                             return 0;
                           },
                           [](const char* path) {
                             if (configfs.bound()) return configfs.refuse(path, EBUSY);
                             return configfs.links.erase(path) > 0 ? 0 : -1;
                           },
                           [](const char* path, const void* data, size_t size) {
                             if (configfs.refuses == path) return configfs.refuse(path, EINVAL);
                             configfs.files[path] =
                                 std::string(static_cast<const char*>(data), size);
                             return 0;
                           }};

class GadgetTest : public testing::Test {
 protected:
  void SetUp() override {
    configfs = {};
    setup_.udc = "dwc3.0";
    std::strcpy(setup_.serial, "0001");
  }
  static std::string file(const std::string& name) {
    return configfs.files["/cfs/usb_gadget/pirvs/" + name];
  }
  static bool has_link(const std::string& name) {
    return configfs.links.count("/cfs/usb_gadget/pirvs/" + name) > 0;
  }
  void expect_nothing_left() const {
    EXPECT_EQ(configfs.folders.size(), 1u);
    EXPECT_TRUE(configfs.links.empty());
    EXPECT_FALSE(configfs.bound());
  }

  const Gadget gadget_{"/cfs", kFake};
  GadgetSetup setup_;
};

TEST_F(GadgetTest, IsMadeAndTakenAwayInOrder) {
  setup_.usb.width = 752;
  setup_.usb.rate_hz = 20;
  ASSERT_EQ(gadget_.make(setup_), nullptr);
  EXPECT_TRUE(configfs.refused.empty()) << configfs.refused[0];
  EXPECT_EQ(file("UDC"), "dwc3.0");
  EXPECT_EQ(file("strings/0x409/serialnumber"), "0001");
  const std::string frame = "functions/uvc.0/streaming/uncompressed/grey/frame/";
  EXPECT_EQ(file(frame + "wWidth"), "752");
  EXPECT_EQ(file(frame + "wHeight"), "480");
  EXPECT_EQ(file(frame + "dwMaxVideoFrameBufferSize"), "360960");
  EXPECT_EQ(file(frame + "dwFrameInterval"), "500000");
  EXPECT_EQ(file("functions/uvc.0/streaming/uncompressed/grey/guidFormat").substr(0, 4), "Y800");
  EXPECT_EQ(file("functions/uvc.0/streaming/uncompressed/grey/guidFormat").size(), 16u);
  for (const char* function : {"ncm.0", "acm.0", "uvc.0"}) {
    EXPECT_TRUE(has_link(std::string("configs/c.1/") + function)) << function;
  }
  gadget_.remove();
  EXPECT_TRUE(configfs.refused.empty()) << configfs.refused[0];
  expect_nothing_left();
}

TEST_F(GadgetTest, HasNoCameraWhenNoneIsWanted) {
  setup_.usb.video = UsbVideo::kNone;
  ASSERT_EQ(gadget_.make(setup_), nullptr);
  EXPECT_FALSE(has_link("configs/c.1/uvc.0"));
  EXPECT_TRUE(has_link("configs/c.1/ncm.0"));
  gadget_.remove();
  expect_nothing_left();
}

// As a predecessor that was killed has left it, whatever it was set to.
TEST_F(GadgetTest, TakesAwayWhatWasLeft) {
  ASSERT_EQ(gadget_.make(setup_), nullptr);
  const Gadget next("/cfs", kFake);
  next.remove();
  expect_nothing_left();
  EXPECT_EQ(next.make(setup_), nullptr);
}

TEST_F(GadgetTest, NamesWhatTheKernelRefusesAndLeavesNothing) {
  for (const char* row : {"/functions/uvc.0", "/functions/ncm.0/dev_addr", "/UDC"}) {
    configfs = {};
    configfs.refuses = std::string("/cfs/usb_gadget/pirvs") + row;
    EXPECT_STREQ(gadget_.make(setup_), row);
    EXPECT_NE(errno, 0);
    if (std::string(row) != "/UDC") expect_nothing_left();
  }
}

TEST(MacAddress, IsLocalOfOneHostAndTheSameForTheSameSerial) {
  std::set<std::string> all;
  for (const char* serial : {"", "0001", "0002", "5b3f9c0d2e114a7f"}) {
    const std::string own = mac_address(serial, false).text, host = mac_address(serial, true).text;
    EXPECT_EQ(own, mac_address(serial, false).text);
    EXPECT_EQ(own.size(), 17u);
    EXPECT_EQ(own.substr(0, 3), "02:");
    EXPECT_EQ(own.substr(0, 16), host.substr(0, 16));
    all.insert({own, host});
  }
  EXPECT_EQ(all.size(), 8u);
}

TEST(MacAddress, DigestsDoNotGiveTheTextAway) {
  char digest[17], other[17];
  put_digest("0123456789abcdef0123456789abcdef\n", digest);
  put_digest("0123456789abcdef0123456789abcdee\n", other);
  EXPECT_EQ(std::string(digest).size(), 16u);
  EXPECT_STRNE(digest, other);
}

TEST(UsbSettings, ReadsItsKeysAndLeavesTheOthers) {
  UsbSettings out;
  EXPECT_FALSE(
      read_usb_settings("camera.left = /dev/video0\nusb.video = right # that one\n"
                        "usb.size = 752 480\nusb.rate_hz = 20\nusb.serial = A1\n"
                        "output.images = /run/i\n",
                        out));
  EXPECT_EQ(out.video, UsbVideo::kRight);
  EXPECT_EQ(out.width, 752);
  EXPECT_EQ(out.height, 480);
  EXPECT_EQ(out.rate_hz, 20);
  EXPECT_STREQ(out.serial, "A1");
  EXPECT_STREQ(out.images, "/run/i");
}

TEST(UsbSettings, SaysWhatIsWrongAndWhere) {
  for (const char* wrong :
       {"usb.video = both", "usb.size = 640", "usb.size = 640 0", "usb.size = 640 480 8",
        "usb.rate_hz = 0", "usb.rate_hz = fast", "usb.serial = a b", "usb.sise = 1",
        "usb.serial = 123456789012345678901234567890123"}) {
    UsbSettings out;
    const ConfigFault fault = read_usb_settings(std::string("\n") + wrong, out);
    EXPECT_TRUE(fault) << wrong;
    EXPECT_EQ(fault.line, 2) << wrong;
  }
}

}  // namespace
}  // namespace pirvs::board
