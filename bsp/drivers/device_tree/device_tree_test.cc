#include "bsp/drivers/device_tree/device_tree.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace pirvs::bsp {
namespace {

// Builds a tree the way a loader does.
class Blob {
 public:
  void begin(const char* name) {
    number(1);
    text(structure_, name);
  }
  void end() { number(2); }
  void property(const char* name, const std::string& value) {
    number(3);
    number(static_cast<uint32_t>(value.size()));
    number(static_cast<uint32_t>(texts_.size()));
    texts_ += name;
    texts_ += '\0';
    structure_ += value;
    pad(structure_);
  }
  std::string finish() {
    number(9);
    std::string out;
    const auto size = static_cast<uint32_t>(40 + structure_.size() + texts_.size());
    for (const uint32_t word :
         {0xd00dfeedu, size, 40u, static_cast<uint32_t>(40 + structure_.size()), 40u, 17u, 16u, 0u,
          static_cast<uint32_t>(texts_.size()), static_cast<uint32_t>(structure_.size())}) {
      put(out, word);
    }
    return out + structure_ + texts_;
  }
  static std::string bytes(uint64_t value, int size) {
    std::string out;
    for (int i = size - 1; i >= 0; --i) out += static_cast<char>(value >> 8 * i);
    return out;
  }

 private:
  static void put(std::string& to, uint32_t word) { to += bytes(word, 4); }
  static void pad(std::string& to) { to.resize((to.size() + 3) / 4 * 4); }
  static void text(std::string& to, const char* value) {
    to += value;
    to += '\0';
    pad(to);
  }
  void number(uint32_t word) { put(structure_, word); }

  std::string structure_;
  std::string texts_;
};

std::string tree(int cells) {
  Blob blob;
  blob.begin("");
  blob.property("compatible", std::string("linux,dummy-virt\0", 17));
  blob.begin("psci");
  blob.property("method", std::string("smc\0", 4));
  blob.end();
  blob.begin("chosen");
  blob.property("bootargs", std::string("cores=4 fault=null\0", 19));
  blob.property("linux,initrd-end", Blob::bytes(0x4a00'0010, 4 * cells));
  blob.property("linux,initrd-start", Blob::bytes(0x4800'0000, 4 * cells));
  blob.end();
  blob.end();
  return blob.finish();
}

TEST(device_tree, gives_what_the_loader_says) {
  for (const int cells : {1, 2}) {
    DeviceTree out;
    ASSERT_EQ(read_device_tree(tree(cells).data(), out), Status::kOk);
    EXPECT_EQ(out.initrd_begin, 0x4800'0000u);
    EXPECT_EQ(out.initrd_end, 0x4a00'0010u);
    EXPECT_EQ(out.firmware, FirmwareCall::kSmc);
    EXPECT_STREQ(out.arguments, "cores=4 fault=null");
    EXPECT_EQ(out.bytes, tree(cells).size());
  }
}

TEST(device_tree, refuses_what_is_none) {
  DeviceTree out;
  EXPECT_EQ(read_device_tree(nullptr, out), Status::kNotFound);
  const std::vector<uint8_t> zeros(64);
  EXPECT_EQ(read_device_tree(zeros.data(), out), Status::kNotFound);
}

// Every word replaced by every one of a few bad ones: it may fail, it must not read beyond the end
// (the sanitizer watches) nor run for ever.
TEST(device_tree, survives_damage) {
  const std::string good = tree(2);
  for (size_t at = 4; at + 4 <= good.size(); at += 4) {
    for (const uint32_t bad : {0u, 1u, 3u, 9u, 0x7fffffffu, 0xffffffffu}) {
      std::string damaged = good;
      damaged.replace(at, 4, Blob::bytes(bad, 4));
      // Its size field may not claim more than there is: a loader's memory goes on behind the blob.
      if (at == 4 && bad > good.size()) continue;
      const std::vector<char> exact(damaged.begin(), damaged.end());
      DeviceTree out;
      (void)read_device_tree(exact.data(), out);
    }
  }
}

TEST(device_tree, a_long_command_line_is_cut) {
  Blob blob;
  blob.begin("");
  blob.property("bootargs", std::string(2 * DeviceTree::kArgumentsMax, 'a'));
  blob.end();
  DeviceTree out;
  ASSERT_EQ(read_device_tree(blob.finish().data(), out), Status::kOk);
  EXPECT_EQ(std::strlen(out.arguments), DeviceTree::kArgumentsMax - 1);
}

TEST(device_tree, finds_words_of_the_command_line) {
  const char* const line = "semihosting cores=4  core=1 name= last=12345678";
  char value[8];
  EXPECT_TRUE(find_argument(line, "semihosting", value, sizeof value));
  EXPECT_STREQ(value, "");
  EXPECT_TRUE(find_argument(line, "cores", value, sizeof value));
  EXPECT_STREQ(value, "4");
  EXPECT_TRUE(find_argument(line, "core", value, sizeof value));
  EXPECT_STREQ(value, "1");
  EXPECT_TRUE(find_argument(line, "name", value, sizeof value));
  EXPECT_STREQ(value, "");
  EXPECT_TRUE(find_argument(line, "last", value, sizeof value));
  EXPECT_STREQ(value, "1234567");
  EXPECT_FALSE(find_argument(line, "semi", value, sizeof value));
  EXPECT_FALSE(find_argument(line, "fault", value, sizeof value));
  EXPECT_FALSE(find_argument("", "fault", value, sizeof value));
}

}  // namespace
}  // namespace pirvs::bsp
