// The card of an RK3399, as `make BOARD=rk3399-bare image` builds it, booted on QEMU: what this
// shows is the way from U-Boot through partition table, FAT, menu, kernel header and initrd into
// our application and to its end. The RK3399's own image and firmware lie on the card and are not
// run.
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "tests/emulator/machine.h"
#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

std::string build_card() {
  const char* const build = std::getenv("PIRVS_BUILD");
  const std::string card = scratch_folder("card") + "/card.img";
  const MachineRun built =
      run_tool("tools/image/build --out " + card + " --firmware " + (build ? build : "build") +
               "/uboot/usr/lib/u-boot/rock-pi-4-rk3399 /recording.bin=" + short_pack() +
               " /pirvs-rk3399-bare.bin=" + image_of("rk3399-bare") + " /pirvs-qemu-virt.bin=" +
               image_of("qemu-virt") + " /extlinux/extlinux.conf=board/rk3399-bare/extlinux.conf");
  EXPECT_EQ(built.status, 0) << built.console;
  return card;
}

// The lines of poses, without what the console puts around them.
std::string poses_of(const std::string& console) {
  std::istringstream lines(console);
  std::string poses;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.rfind("pose ", 0) == 0) poses += line.substr(5) + "\n";
  }
  return poses;
}

TEST(rk3399_card, boots_through_u_boot_into_the_application_and_to_its_exit_code) {
  const MachineRun run = run_tool("tools/emulator/card " + build_card());
  EXPECT_EQ(run.status, 0) << run.console;
  for (const char* text :
       {"Found /extlinux/extlinux.conf", "PIRVS on the RK3399", "Retrieving file: /recording.bin",
        "Starting kernel", "PIRVS on qemu-virt, 4 cores", "tracking at the end"}) {
    EXPECT_TRUE(run.says(text)) << text << " is missing:\n" << run.console;
  }
  // The same poses as without U-Boot and card.
  const MachineRun plain = run_machine("qemu-virt", short_pack(), "");
  EXPECT_FALSE(plain.trajectory.empty());
  EXPECT_EQ(poses_of(run.console), plain.trajectory);
}

}  // namespace
}  // namespace pirvs::systems
