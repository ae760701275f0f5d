// A PWM by sysfs: files of our own.
#include "bsp/linux/pwm_trigger.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "bsp/api/clock.h"
#include "bsp/linux/sysfs.h"

namespace pirvs::bsp {
namespace {

namespace fs = std::filesystem;

constexpr TriggerTiming k60Hz = {16'666'667, 1'000'000, 0, false};

class PwmTriggerTest : public testing::Test {
 protected:
  PwmTriggerTest() {
    root_ = (fs::temp_directory_path() / ("pwm_" + std::to_string(getpid()))).string();
    fs::remove_all(root_);
    chip_ = root_ + "/sys/class/pwm/pwmchip2";
    fs::create_directories(chip_ + "/pwm1");
    for (const char* file : {"period", "duty_cycle", "polarity", "enable"}) write(file, "?");
    trigger_.configure(2, 1, root_.c_str());
  }
  ~PwmTriggerTest() override { fs::remove_all(root_); }

  void write(const char* file, const char* text) { std::ofstream(chip_ + "/pwm1/" + file) << text; }
  std::string value(const char* file) const {
    std::stringstream text;
    text << std::ifstream(chip_ + "/pwm1/" + file).rdbuf();
    return text.str();
  }

  std::string root_, chip_;
  PwmTrigger trigger_;
};

TEST_F(PwmTriggerTest, SetsRateAndWidthAndSaysHowWellItKnowsTheStart) {
  const TimeNs before = now();
  const Result<TriggerStart> start = trigger_.start(k60Hz);
  ASSERT_TRUE(start.ok()) << trigger_.why();
  EXPECT_EQ(value("period"), "16666667");
  EXPECT_EQ(value("duty_cycle"), "1000000");
  EXPECT_EQ(value("polarity"), "normal");
  EXPECT_EQ(value("enable"), "1");
  EXPECT_EQ(start.value().period_ns, 16'666'667);
  EXPECT_GT(start.value().first_t, before);
  EXPECT_GT(start.value().error_ns, 0);
  EXPECT_EQ(trigger_.stop(), Status::kOk);
  EXPECT_EQ(value("enable"), "0");
}

TEST_F(PwmTriggerTest, BeginsAtThePhaseAsFarAsUserSpaceCan) {
  const TriggerTiming timing = {20'000'000, 500'000, 7'000'000, true};
  const Result<TriggerStart> start = trigger_.start(timing);
  ASSERT_TRUE(start.ok());
  const TimeNs late = (start.value().first_t - timing.phase_ns) % timing.period_ns;
  EXPECT_LT(late, 15'000'000) << "this machine may be busy, but not before its time";
  EXPECT_EQ(value("polarity"), "inversed");
}

TEST_F(PwmTriggerTest, SaysWhatIsWrong) {
  EXPECT_EQ(trigger_.start({1000, 1000, 0, false}).status(), Status::kBadData);
  EXPECT_EQ(trigger_.start({1000, 0, 0, false}).status(), Status::kBadData);
  EXPECT_EQ(trigger_.start({1000, 10, 1000, false}).status(), Status::kBadData);
  PwmTrigger other;
  other.configure(7, 0, root_.c_str());
  EXPECT_EQ(other.start(k60Hz).status(), Status::kNotFound);
  EXPECT_STREQ(other.why(), "no such PWM chip");
  other.configure(2, 5, root_.c_str());
  EXPECT_EQ(other.start(k60Hz).status(), Status::kNotFound);
  EXPECT_STREQ(other.why(), "no such channel of this PWM chip");
  fs::remove(chip_ + "/pwm1/period");
  EXPECT_EQ(trigger_.start(k60Hz).status(), Status::kBusFault);
  EXPECT_STREQ(trigger_.why(), "the PWM refuses this rate or width");
}

TEST_F(PwmTriggerTest, ExportsAndGivesBackWhatNobodyHadExported) {
  fs::rename(chip_ + "/pwm1", chip_ + "/away");
  std::ofstream(chip_ + "/export") << "";
  std::ofstream(chip_ + "/unexport") << "";
  EXPECT_EQ(trigger_.start(k60Hz).status(), Status::kBusFault) << "this kernel makes no folder";
  char line[16];
  ASSERT_TRUE(read_line((chip_ + "/export").c_str(), line, sizeof line));
  EXPECT_STREQ(line, "1");
  fs::rename(chip_ + "/away", chip_ + "/pwm1");
  ASSERT_TRUE(trigger_.start(k60Hz).ok());
  EXPECT_EQ(trigger_.stop(), Status::kOk);
  ASSERT_TRUE(read_line((chip_ + "/unexport").c_str(), line, sizeof line));
  EXPECT_STREQ(line, "1");
}

TEST(Sysfs, FindsAValueInLinesOfAUevent) {
  EXPECT_EQ(value_of("MAJOR=81\nDEVNAME=video3\n", "DEVNAME"), "video3");
  EXPECT_EQ(value_of("MAJOR=81\nDEVNAME=video3", "MAJOR"), "81");
  EXPECT_TRUE(value_of("XDEVNAME=1\nDEVNAMES=2\n", "DEVNAME").empty());
  EXPECT_TRUE(value_of("", "DEVNAME").empty());
}

}  // namespace
}  // namespace pirvs::bsp
