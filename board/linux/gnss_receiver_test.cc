#include "board/linux/gnss_receiver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "board/linux/settings.h"
#include "board/linux/testing_line_test.h"
#include "modules/gnss/nmea_sentence_test.h"
#include "modules/testing.h"

namespace pirvs::board {
namespace {

constexpr TimeNs kSecond = 1'000'000'000, kMilli = 1'000'000;

TimeNs clock_t_ = 0;  // of the device

// A receiver at the other end of a line, and the door.
class GnssReceiverTest : public ::testing::Test {
 protected:
  void SetUp() override {
    clock_t_ = 120 * kSecond;
    ASSERT_EQ(read_text(line_.path(), settings_.serial), nullptr);
    GnssSinks sinks;
    sinks.context = this;
    sinks.deliver = [](void* context, const Arrival& arrival) {
      static_cast<GnssReceiverTest*>(context)->fixes_.push_back(arrival.gnss);
      return Status::kOk;
    };
    sinks.now = [] { return clock_t_; };
    sinks.news = {this, [](void* context, const char*, const char* what) {
                    static_cast<GnssReceiverTest*>(context)->news_.emplace_back(what);
                  }};
    sinks_ = sinks;
  }
  void open() { ASSERT_EQ(receiver_.open(settings_, sinks_), nullptr); }
  void wait(TimeNs time) {
    clock_t_ += time;
    receiver_.poll();
  }
  void say(const std::string& bytes) {
    constexpr size_t kPiece = 512;
    for (size_t at = 0; at < bytes.size(); at += kPiece) {
      line_.type(bytes.substr(at, kPiece));
      receiver_.poll();
    }
  }
  // GGA and RMC of this second.
  static std::string fix() {
    const int second = int(clock_t_ / kSecond % 60);
    char text[120];
    std::snprintf(text, sizeof text,
                  "GNGGA,1200%02d.00,4723.86,N,00832.736,E,4,12,0.6,450,M,48,M,,", second);
    std::string out = testing::sentence(text);
    std::snprintf(text, sizeof text, "GNRMC,1200%02d.00,A,4723.86,N,00832.736,E,1.0,90,271126,,,R",
                  second);
    return out + testing::sentence(text);
  }

  TestingLine line_{"pirvs_gnss"};
  GnssSettings settings_;
  GnssSinks sinks_;
  GnssReceiver receiver_;
  std::vector<GnssFix> fixes_;
  std::vector<std::string> news_;
};

TEST_F(GnssReceiverTest, TellsWhatIsMissingAndGoesOnWhenItComes) {
  open();
  for (int i = 0; i < 10; ++i) wait(kSecond);
  ASSERT_EQ(news_.size(), 1u) << "once";
  EXPECT_NE(news_[0].find("no receiver there"), std::string::npos);
  line_.plug();
  wait(kSecond);
  for (int k = 0; k < 4; ++k) {
    wait(kSecond);
    say(fix());
  }
  EXPECT_EQ(fixes_.size(), 3u) << "what the first one lacked was told by the second";
  EXPECT_NE(news_.back().find("fixes come"), std::string::npos);
  line_.unplug();
  wait(kSecond);
  EXPECT_NE(news_.back().find("gone"), std::string::npos);
  line_.plug();
  wait(kSecond);
  EXPECT_EQ(news_.back(), "back");
  const size_t before = fixes_.size();
  for (int k = 10; k < 14; ++k) {
    wait(kSecond);
    say(fix());
  }
  EXPECT_EQ(fixes_.size(), before + 4);
  EXPECT_EQ(receiver_.counters().opened, 2u);
}

TEST_F(GnssReceiverTest, TellsSilenceAndBytesThatAreNone) {
  line_.plug();
  open();
  wait(0);
  wait(6 * kSecond);
  ASSERT_EQ(news_.size(), 1u);
  EXPECT_NE(news_[0].find("silent"), std::string::npos);
  for (int k = 0; k < 10; ++k) {
    say(std::string(100, '\xa5'));
    wait(kSecond);
  }
  ASSERT_EQ(news_.size(), 2u);
  EXPECT_NE(news_[1].find("is the speed right"), std::string::npos);
}

TEST_F(GnssReceiverTest, WhatIsNoLineIsRefused) {
  ASSERT_EQ(read_text("/dev/null", settings_.serial), nullptr);
  open();
  wait(0);
  ASSERT_EQ(news_.size(), 1u);
  EXPECT_EQ(news_[0], "is no serial line");
}

TEST_F(GnssReceiverTest, AFloodIsCutOff) {
  line_.plug();
  open();
  wait(0);
  // A thousand fixes at once, each later than the one before by its own time.
  for (int k = 0; k < 1000; ++k) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "GNGGA,12%02d%02d.%d,4723.86,N,00832.736,E,4,12,0.6,450,M,48,M,,", k / 600,
                  k / 10 % 60, k % 10);
    say(testing::sentence(text));
    clock_t_ += kMilli;
  }
  EXPECT_LE(fixes_.size(), 50u + 50 + 1);
  EXPECT_GT(receiver_.counters().flood, 800u);
}

TEST_F(GnssReceiverTest, HearsDatagrams) {
  settings_.serial = SettingText{};
  settings_.has_udp = true;
  settings_.udp = {0x7f00'0001, 0};
  ASSERT_EQ(set_gnss_setting(settings_, "", "udp:127.0.0.1:47115"), nullptr);
  open();
  const Result<bsp::Socket> socket = bsp::datagram_open({0x7f00'0001, 0});
  ASSERT_TRUE(socket.ok());
  for (int k = 0; k < 5; ++k) {
    const std::string text = fix();
    ASSERT_EQ(bsp::datagram_send(socket.value(), settings_.udp, text.data(), text.size()),
              Status::kOk);
    wait(kSecond);
  }
  EXPECT_EQ(fixes_.size(), 4u);
  bsp::datagram_close(socket.value());
}

TEST(gnss_receiver, what_a_stamp_is_off_by_is_in_the_noise) {
  GnssFix fix;
  fix.sigma_horizontal_m = 0.01;
  fix.sigma_vertical_m = 0.02;
  fix.sigma_velocity_m_s = 0.03;
  fix.has_velocity = true;
  fix.v_ned = Vec3(3, 4, -1);
  widen_by(40e6, fix);
  EXPECT_NEAR(fix.sigma_horizontal_m, std::hypot(0.01, 0.2), 1e-12);
  EXPECT_NEAR(fix.sigma_vertical_m, std::hypot(0.02, 0.04), 1e-12);
  EXPECT_NEAR(fix.sigma_velocity_m_s, std::hypot(0.03, 0.08), 1e-12);
  fix.v_ned.z() = NAN;
  fix.sigma_vertical_m = 0.02;
  widen_by(40e6, fix);
  EXPECT_NEAR(fix.sigma_vertical_m, std::hypot(0.02, 0.2), 1e-12) << "as fast as over ground";
}

// ---- a walk's bytes ----------------------------------------------------------------------------

struct Spread {
  int count = 0;
  double mean_ms = 0, rms_ms = 0, worst_ms = 0;  // rms and worst: about the mean
};

// Of stamps against the truth.
Spread spread_of(const std::vector<double>& off_ns) {
  Spread out;
  out.count = int(off_ns.size());
  for (const double off : off_ns) out.mean_ms += 1e-6 * off / out.count;
  for (const double off : off_ns) {
    const double off_ms = 1e-6 * off - out.mean_ms;
    out.rms_ms += off_ms * off_ms / out.count;
    out.worst_ms = std::max(out.worst_ms, std::fabs(off_ms));
  }
  out.rms_ms = std::sqrt(out.rms_ms);
  return out;
}

class GnssWalk : public GnssReceiverTest {
 protected:
  static constexpr double kRate_ppb = 31e3;  // the device's clock is fast
  static constexpr TimeNs kLatency = 60 * kMilli;
  static constexpr double kJitter_s = 0.006;

  // The bytes of each fix, and its own time.
  struct Epoch {
    std::string bytes;
    TimeNs t_utc = 0;
  };

  bool read_walk() {
    const char* const root = std::getenv("PIRVS_DATA");
    const std::string path =
        std::string(root != nullptr ? root : "../shared/data") + "/gnss_walk/gnss.ubx";
    std::ostringstream all;
    all << std::ifstream(path, std::ios::binary).rdbuf();
    const std::string bytes = all.str();
    UbxReader reader;
    ReceiverFix fix;
    Epoch epoch;
    for (const char c : bytes) {
      epoch.bytes.push_back(c);
      if (!reader.take(uint8_t(c), fix)) continue;
      epoch.t_utc = fix.t_utc;
      walk_.push_back(epoch);
      epoch.bytes.clear();
    }
    return !walk_.empty();
  }

  TimeNs ours(TimeNs t_utc) const {
    const TimeNs since = t_utc - walk_[0].t_utc;
    return 5000 * kSecond + since + TimeNs(std::llround(kRate_ppb * 1e-9 * double(since)));
  }

  Spread walk(bool with_pulses) {
    testing::Random random(3);
    bsp::Pps pps;
    std::vector<double> off_ns;
    TimeNs second = walk_[0].t_utc / kSecond * kSecond;
    for (const Epoch& epoch : walk_) {
      for (; with_pulses && second <= epoch.t_utc; second += kSecond) {
        // Interrupts are a few microseconds late.
        (void)pps.add(ours(second) + TimeNs(random.uniform(1e3, 8e3)));
        if (pps.known()) receiver_.pulse(pps);
      }
      const double jitter_s = -kJitter_s * std::log(1 - random.uniform(0, 0.999));
      clock_t_ = ours(epoch.t_utc) + kLatency + from_seconds(jitter_s);
      const size_t before = fixes_.size();
      say(epoch.bytes);
      const bool counts = !with_pulses || receiver_.counters().by_pulse > 0;
      if (counts && fixes_.size() > before)
        off_ns.push_back(double(fixes_.back().t - ours(epoch.t_utc)));
    }
    return spread_of(off_ns);
  }

  std::vector<Epoch> walk_;
};

TEST_F(GnssWalk, AllItsFixesComeOverALine) {
  if (!read_walk()) GTEST_SKIP() << "no gnss_walk among the recordings";
  line_.plug();
  open();
  wait(0);
  const Spread spread = walk(false);
  std::printf(
      "without pulses: %d of %zu fixes, stamps off by %.2f ms, spread %.2f ms rms, %.2f ms "
      "at most; sigma %.1f ms\n",
      spread.count, walk_.size(), spread.mean_ms, spread.rms_ms, spread.worst_ms,
      1e-3 * receiver_.counters().sigma_us);
  EXPECT_EQ(size_t(spread.count), walk_.size());
  EXPECT_LT(spread.rms_ms, 2.5);
  EXPECT_LT(std::fabs(spread.mean_ms), 1e-3 * receiver_.counters().sigma_us);
  EXPECT_EQ(receiver_.counters().by_pulse, 0u);
}

TEST_F(GnssWalk, ItsPulsesSayWhenToMicroseconds) {
  if (!read_walk()) GTEST_SKIP() << "no gnss_walk among the recordings";
  line_.plug();
  open();
  wait(0);
  const Spread spread = walk(true);
  std::printf(
      "with pulses: %d of %zu fixes, %u by them, stamps off by %.1f us, spread %.1f us rms; "
      "sigma %u us\n",
      spread.count, walk_.size(), uint32_t(receiver_.counters().by_pulse), 1e3 * spread.mean_ms,
      1e3 * spread.rms_ms, uint32_t(receiver_.counters().sigma_us));
  EXPECT_EQ(fixes_.size(), walk_.size());
  EXPECT_GE(spread.count, int(walk_.size()) - 8) << "three pulses make a clock";
  EXPECT_EQ(receiver_.counters().by_pulse, uint32_t(spread.count));
  EXPECT_LT(std::fabs(spread.mean_ms), 0.01);
  EXPECT_LT(spread.worst_ms, 0.01);
  EXPECT_LE(receiver_.counters().sigma_us, 10u);
}

}  // namespace
}  // namespace pirvs::board
