// The PC's side of an update, against a device that is a thread: what it is told, and what it makes
// of each answer.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include "tools/dataset/input_error.h"
#include "tools/update/device_link.h"

namespace pirvs::tools {
namespace {

// Takes one connection and does with it what a test says.
class FakeDevice {
 public:
  explicit FakeDevice(const std::function<void(int)>& serve) {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&here), size), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&here), &size);
    host = "127.0.0.1:" + std::to_string(ntohs(here.sin_port));
    thread_ = std::thread([this, serve] {
      const int fd = accept(listener_, nullptr, nullptr);
      serve(fd);
      close(fd);
    });
  }
  ~FakeDevice() {
    thread_.join();
    close(listener_);
  }
  FakeDevice(const FakeDevice&) = delete;
  FakeDevice& operator=(const FakeDevice&) = delete;

  std::string host;

 private:
  int listener_ = -1;
  std::thread thread_;
};

void answer(int fd, const std::string& text) {
  EXPECT_EQ(send(fd, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
}

std::string take(int fd, size_t size) {
  std::string out(size, 0);
  const ssize_t got = recv(fd, out.data(), size, MSG_WAITALL);
  out.resize(got < 0 ? 0 : static_cast<size_t>(got));
  return out;
}

TEST(device_link, lines_come_whole_however_they_are_cut) {
  const FakeDevice device([](int fd) {
    EXPECT_EQ(take(fd, 16), "pirvs 1 version\n");
    answer(fd, "one\ntw");
    answer(fd, "o\nrest");
  });
  DeviceLink link(device.host);
  link.send("pirvs 1 version\n");
  std::string line;
  EXPECT_TRUE(link.read_line(line));
  EXPECT_EQ(line, "one");
  EXPECT_TRUE(link.read_line(line));
  EXPECT_EQ(line, "two");
  EXPECT_FALSE(link.read_line(line)) << "no end";
}

TEST(device_link, a_file_goes_whole_and_its_progress_is_told) {
  const std::string path = testing::TempDir() + "/pirvs_update_test";
  const std::string content(700'000, 'u');
  std::ofstream(path, std::ios::binary) << content;
  std::string got;
  uint64_t told = 0;
  {
    const FakeDevice device([&](int fd) { got = take(fd, content.size()); });
    DeviceLink link(device.host);
    link.send_file(path, content.size(), [&](uint64_t done) {
      EXPECT_GT(done, told);
      told = done;
    });
  }
  EXPECT_TRUE(got == content);
  EXPECT_EQ(told, content.size());
  std::remove(path.c_str());
}

TEST(device_link, a_device_that_refuses_ends_the_transfer) {
  const std::string path = testing::TempDir() + "/pirvs_update_test_refused";
  std::ofstream(path, std::ios::binary) << std::string(8'000'000, 'u');
  const FakeDevice device([](int fd) {
    answer(fd, "refused no memory for the bundle\n");
    while (!take(fd, 1 << 16).empty()) continue;
  });
  {
    DeviceLink link(device.host);
    uint64_t told = 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    link.send_file(path, 8'000'000, [&](uint64_t done) { told = done; });
    EXPECT_LT(told, 8'000'000u);
    std::string line;
    EXPECT_TRUE(link.read_line(line));
    EXPECT_EQ(line, "refused no memory for the bundle");
  }
  std::remove(path.c_str());
}

TEST(device_link, says_what_is_wrong_with_the_host) {
  try {
    const DeviceLink link("no-such-host.invalid");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no such host"), std::string::npos);
  }
  std::string gone;
  {
    const FakeDevice device([](int) {});
    gone = device.host;
    DeviceLink last(gone);
  }
  try {
    const DeviceLink link(gone);
    FAIL();
  } catch (const LinkError& error) {
    EXPECT_EQ(error.what(), gone + ": Connection refused");
  }
}

}  // namespace
}  // namespace pirvs::tools
