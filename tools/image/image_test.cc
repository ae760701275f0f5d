// The card: its layout, and what may be written to. The programs are run as a person runs them, on
// a made-up firmware, a made-up /sys and a file for a device.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace pirvs {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int status;
  std::string output;  // standard output and error
};

std::string contents(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class Card : public testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/pirvs_card_XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    root_ = name;
    write("firmware/idbloader.img", "\x3b\x8c\xdc\xfc" + std::string(100'000, 'i'));
    write("firmware/u-boot.itb", "\xd0\x0d\xfe\xed" + std::string(1'000'000, 'u'));
    write("app.bin", std::string(900'000, 'a'));
    write("extlinux.conf", "default pirvs\n");
  }
  void TearDown() override { fs::remove_all(root_); }

  void write(const std::string& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path, std::ios::binary) << text;
  }
  std::string at(const std::string& path) const { return (root_ / path).string(); }

  Outcome run(const std::string& command, const std::string& input = "") const {
    write("input", input);
    const std::string line = command + " <" + at("input") + " >" + at("output") + " 2>&1";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(root_ / "output")};
  }
  Outcome build() const {
    return run("tools/image/build --out " + at("card.img") + " --firmware " + at("firmware") +
               " /pirvs.bin=" + at("app.bin") + " /extlinux/extlinux.conf=" + at("extlinux.conf"));
  }
  Outcome check() const {
    return run(
        "python3 -B -c 'import sys; sys.path.insert(0, \"tools/image\"); import layout; "
        "layout.check(\"" +
        at("card.img") + "\", \"" + at("firmware") + "\", {\"/pirvs.bin\": \"" + at("app.bin") +
        "\"})'");
  }
  void damage(long offset) const {
    std::fstream file(root_ / "card.img", std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(offset);
    const char byte = static_cast<char>(file.get() ^ 0x10);
    file.seekp(offset);
    file.put(byte);
  }

  fs::path root_;
};

TEST_F(Card, HoldsEverythingAtItsPlace) {
  const Outcome built = build();
  ASSERT_EQ(built.status, 0) << built.output;
  const std::string card = contents(root_ / "card.img");
  EXPECT_EQ(card.substr(64 * 512, 100'004), contents(root_ / "firmware/idbloader.img"));
  EXPECT_EQ(card.substr(16384 * 512, 1'000'004), contents(root_ / "firmware/u-boot.itb"));
  EXPECT_EQ(card.substr(512, 8), "EFI PART");
  EXPECT_EQ(card.substr(card.size() - 512, 8), "EFI PART");
  EXPECT_EQ(card.substr(16 * 1024 * 1024 + 82, 5), "FAT32");
  ASSERT_EQ(build().status, 0);
  EXPECT_TRUE(card == contents(root_ / "card.img")) << "the same files must give the same bytes";
}

TEST_F(Card, TheReaderSeesDamage) {
  ASSERT_EQ(build().status, 0);
  ASSERT_EQ(check().status, 0) << check().output;
  const struct {
    long offset;
    const char* says;
  } damages[] = {
      {512 + 60, "GPT header"},
      {1024 + 40, "GPT entries"},
      {64 * 512 + 50'000, "idbloader.img is not whole"},
      {16384 * 512 + 500'000, "u-boot.itb is not whole"},
      {16 * 1024 * 1024 + 82, "not FAT32"},
  };
  for (const auto& [offset, says] : damages) {
    damage(offset);
    const Outcome checked = check();
    EXPECT_NE(checked.status, 0) << offset;
    EXPECT_NE(checked.output.find(says), std::string::npos) << checked.output;
    damage(offset);  // the same bit again: whole
  }
  write("app.bin", "another");
  EXPECT_NE(check().output.find("/pirvs.bin is not"), std::string::npos);
}

TEST_F(Card, IsNotBuiltFromWrongFirmware) {
  write("firmware/idbloader.img", "not for a boot ROM");
  const Outcome built = build();
  EXPECT_EQ(built.status, 2);
  EXPECT_NE(built.output.find("idbloader.img"), std::string::npos) << built.output;
  EXPECT_FALSE(fs::exists(root_ / "card.img"));
}

// A disk `sdz` of 4 MiB in a made-up /sys, with one partition; each test spoils one thing.
class Flash : public Card {
 protected:
  void SetUp() override {
    Card::SetUp();
    write("card.img", std::string(1'500'000, 'c'));
    write("dev/sdz", std::string(4 << 20, '-'));
    const std::string disk = "sys/devices/usb/block/sdz";
    write(disk + "/removable", "1\n");
    write(disk + "/ro", "0\n");
    write(disk + "/size", "8192\n");
    write(disk + "/dev", "8:16\n");
    write(disk + "/device/model", "Card Reader\n");
    write(disk + "/sdz1/partition", "1\n");
    write(disk + "/sdz1/dev", "8:17\n");
    write("proc/self/mountinfo", "1 0 8:1 / / rw - ext4 /dev/sda1 rw\n");
    write("proc/swaps", "Filename Type Size Used Priority\n");
    fs::create_directories(root_ / "sys/class/block");
    fs::create_symlink("../../devices/usb/block/sdz", root_ / "sys/class/block/sdz");
    fs::create_symlink("../../devices/usb/block/sdz/sdz1", root_ / "sys/class/block/sdz1");
    write("dev/sdz1", "");
  }
  Outcome flash(const std::string& device = "sdz", const std::string& answer = "sdz\n") const {
    return run("tools/image/flash --sysfs " + at("sys") + " --proc " + at("proc") + " " +
                   at("card.img") + " " + at("dev/" + device),
               answer);
  }
  void expect_refused(const std::string& why, const std::string& device = "sdz") const {
    const Outcome refused = flash(device);
    EXPECT_EQ(refused.status, 2) << why;
    EXPECT_NE(refused.output.find(why), std::string::npos) << refused.output;
    EXPECT_EQ(contents(root_ / "dev/sdz").find('c'), std::string::npos) << why;
  }
  void spoil(const std::string& file, const std::string& text, const std::string& why) const {
    const std::string before = contents(root_ / file);
    write(file, text);
    expect_refused(why);
    write(file, before);
  }
};

TEST_F(Flash, WritesTheImageAndNothingBehindIt) {
  const Outcome done = flash();
  ASSERT_EQ(done.status, 0) << done.output;
  EXPECT_NE(done.output.find("Card Reader, 0.0 GB"), std::string::npos) << done.output;
  const std::string device = contents(root_ / "dev/sdz");
  ASSERT_EQ(device.size(), size_t{4} << 20);
  EXPECT_EQ(device.substr(0, 1'500'000), contents(root_ / "card.img"));
  EXPECT_EQ(device.find_first_not_of('-', 1'500'000), std::string::npos);
}

TEST_F(Flash, AsksForTheNameOfTheDisk) {
  for (const char* answer : {"", "y\n", "sda\n"}) {
    EXPECT_EQ(flash("sdz", answer).status, 1) << answer;
    EXPECT_EQ(contents(root_ / "dev/sdz").find('c'), std::string::npos);
  }
}

TEST_F(Flash, RefusesWhatIsNoCard) {
  const std::string disk = "sys/devices/usb/block/sdz/";
  expect_refused("no such device", "sdq");
  expect_refused("a partition; name the whole disk, sdz", "sdz1");
  spoil(disk + "removable", "0\n", "not removable");
  spoil(disk + "ro", "1\n", "write-protected");
  spoil(disk + "size", "0\n", "no card");
  spoil(disk + "size", "2048\n", "1 MiB, the image needs 2 MiB");
  const std::string mounts = "proc/self/mountinfo";
  spoil(mounts, "9 1 8:17 / /run/card rw - vfat /dev/sdz1 rw\n", "sdz1 is mounted on /run");
  spoil(mounts, "9 1 8:16 / /run/card rw - vfat /dev/sdz rw\n", "sdz is mounted on /run");
  spoil("proc/swaps", "Filename Type\n/dev/sdz1 partition\n", "sdz1 is swap");
  fs::create_directories(root_ / (disk + "sdz1/holders/dm-0"));
  expect_refused("sdz1 belongs to dm-0");
}

TEST_F(Flash, TakesAnSdCardInABuiltInReader) {
  write("sys/devices/usb/block/sdz/removable", "0\n");
  write("sys/devices/usb/block/sdz/device/type", "SD\n");
  EXPECT_EQ(flash().status, 0);
}

TEST_F(Flash, RefusesAFileOnARealMachine) {
  const Outcome refused = run("tools/image/flash " + at("card.img") + " " + at("dev/sdz"));
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.output.find("not a block device"), std::string::npos) << refused.output;
}

// rkdeveloptool is replaced by a script that lists `board` and notes what it was asked.
class FlashUsb : public Card {
 protected:
  Outcome flash(const std::string& board, const std::string& rest, const std::string& answer) {
    write("board", board);
    write("log", "");
    write("bin/rkdeveloptool", "#!/bin/sh\nif [ \"$1\" = ld ]; then cat " + at("board") +
                                   "; else echo \"$1 $2\" >> " + at("log") + "; fi\n");
    fs::permissions(root_ / "bin/rkdeveloptool", fs::perms::owner_all);
    return run("PATH=" + at("bin") + ":$PATH tools/image/flash_usb card.img " + rest, answer);
  }
  std::string log() const { return contents(root_ / "log"); }
  const std::string loader_ = "DevNo=1\tVid=0x2207,Pid=0x330c,LocationID=101\tLoader\n";
  const std::string maskrom_ = "DevNo=1\tVid=0x2207,Pid=0x330c,LocationID=101\tMaskrom\n";
};

TEST_F(FlashUsb, WritesThroughALoader) {
  EXPECT_EQ(flash(loader_, "", "rk3399\n").status, 0);
  EXPECT_EQ(log(), "wl 0\nrd \n");
}

TEST_F(FlashUsb, StartsTheMemoryFirstInMaskRomMode) {
  EXPECT_EQ(flash(maskrom_, "", "rk3399\n").status, 2);
  EXPECT_EQ(log(), "");
  EXPECT_EQ(flash(maskrom_, "loader.bin", "rk3399\n").status, 0);
  EXPECT_EQ(log(), "db loader.bin\nwl 0\nrd \n");
}

TEST_F(FlashUsb, RefusesNoneSeveralAndTheUnconfirmed) {
  EXPECT_EQ(flash("", "", "rk3399\n").status, 2);
  EXPECT_EQ(flash(loader_ + loader_, "", "rk3399\n").status, 2);
  EXPECT_EQ(flash("DevNo=1\tVid=0x2207,Pid=0x350b,LocationID=101\tLoader\n", "", "rk3399\n").status,
            2);
  EXPECT_EQ(flash(loader_, "", "yes\n").status, 1);
  EXPECT_EQ(log(), "");
}

// What RAUC asks of the card of ironsides, after it has written slot b. pirvs-card is replaced by a
// script that notes what it was asked; the partitions are files.
class Backend : public Card {
 protected:
  void SetUp() override {
    Card::SetUp();
    write("bin/pirvs-card", "#!/bin/sh\nif [ $1 = get ]; then cat " + at("state") +
                                "; else echo $* >> " + at("log") + "; fi\n");
    fs::permissions(root_ / "bin/pirvs-card", fs::perms::owner_all);
    write("state", "good=a trial= left=0 (copy 1)\n");
    write("log", "");
    write("disks/root-b", "a root" + std::string(100'000, 0));  // partitions are larger
    write("disks/kernel-b", "a kernel" + std::string(100'000, 0));
    // Of "a root" and "a kernel".
    write("status",
          "[slot.rootfs.0]\nsha256=1\nsize=1\n\n[slot.rootfs.1]\nbundle.version=2\nsha256=" +
              sum("a root") + "\nsize=6\n\n[slot.kernel.1]\nsize=8\nsha256=" + sum("a kernel") +
              "\n");
  }
  std::string sum(const std::string& text) const {
    write("text", text);
    return run("sha256sum " + at("text")).output.substr(0, 64);
  }
  Outcome ask(const std::string& words) const {
    return run("PATH=" + at("bin") + ":$PATH STATUS=" + at("status") + " DISKS=" + at("disks") +
               " sh board/ironsides/image/root/usr/lib/pirvs/rauc-backend " + words);
  }
  std::string log() const { return contents(root_ / "log"); }
};

TEST_F(Backend, ASlotIsTriedWhenItHoldsWhatWasWritten) {
  EXPECT_EQ(ask("set-primary b").status, 0);
  EXPECT_EQ(log(), "try b 3\n");
}

TEST_F(Backend, ASlotThatReadsBackOtherwiseIsNot) {
  for (const char* part : {"root-b", "kernel-b"}) {
    const std::string before = contents(root_ / "disks" / part);
    write(std::string("disks/") + part, "A" + before.substr(1));
    const Outcome asked = ask("set-primary b");
    EXPECT_NE(asked.status, 0);
    EXPECT_NE(asked.output.find(std::string(part) + ": not what was written"), std::string::npos);
    write(std::string("disks/") + part, before);
  }
  EXPECT_NE(ask("set-primary a").status, 0) << "of which nothing was noted";
  EXPECT_EQ(log(), "");
}

TEST_F(Backend, TellsAndSetsWhatIsGood) {
  EXPECT_EQ(ask("get-primary").output, "a\n");
  write("state", "good=a trial=b left=3 (copy 1)\n");
  EXPECT_EQ(ask("get-primary").output, "b\n");
  EXPECT_EQ(ask("set-state b good").status, 0);
  EXPECT_EQ(ask("set-state b bad").status, 0);
  EXPECT_EQ(log(), "good b\n");
}

}  // namespace
}  // namespace pirvs
