#include "tools/dataset/trajectory.h"

#include <gtest/gtest.h>

#include "tools/dataset/input_error.h"
#include "tools/dataset/test_recording.h"
#include "tools/dataset/text_table.h"

namespace pirvs::tools {
namespace {

// The stamp in the first column of the table's first row, and what is in doubt of it.
struct Stamp {
  explicit Stamp(const std::string& table) {
    const TestRecording disk;
    disk.write("a.csv", table);
    try {
      TextTable rows(disk.path("a.csv"), "numbers");
      if (rows.next()) t = rows.stamp();
    } catch (const InputError& error) {
      doubt = error.what();
    }
  }
  std::optional<TimeNs> t;
  std::string doubt;
};

TEST(text_table, stamps_are_exact) {
  EXPECT_EQ(Stamp("1403636584763555584").t, TimeNs{1403636584763555584});
  EXPECT_EQ(Stamp("1403636584.763555584").t, TimeNs{1403636584763555584});
  EXPECT_EQ(Stamp("0.026060").t, TimeNs{26'060'000});
  EXPECT_EQ(Stamp("-0.5").t, TimeNs{-500'000'000});
  for (const char* bad : {"x", "1.2.3", "99999999999999999999", "nan"}) {
    EXPECT_FALSE(Stamp(bad).t) << bad;
    EXPECT_EQ(Stamp(bad).doubt, "");
  }
  EXPECT_FALSE(Stamp("1e9").t) << "a number, of whatever unit";
}

TEST(text_table, the_whole_column_decides_what_integers_are) {
  EXPECT_EQ(Stamp("12 0\n13 0\n14 0\n").t, TimeNs{12'000'000'000});
  EXPECT_EQ(Stamp("12 0\n12.5 0\n").t, TimeNs{12'000'000'000}) << "others have a decimal point";
  // Since the device was started.
  EXPECT_EQ(Stamp("#t [ns]\n73000000000,0\n73050000000,0\n73100000000,0\n").t,
            TimeNs{73'000'000'000});
  EXPECT_EQ(Stamp("0,0\n5000000,0\n10000000,0\n").t, TimeNs{0});
  EXPECT_EQ(Stamp("5000000,0\n0,0\n5000000,0\n5000000,0\n").t, TimeNs{5'000'000})
      << "whatever their order";
  EXPECT_EQ(Stamp("73000000000,0\n").t, TimeNs{73'000'000'000}) << "no clock shows the year 4283";
}

TEST(text_table, integers_that_may_be_either_are_refused) {
  for (const char* table : {"12 0\n", "0 0\n50000 0\n100000 0\n"}) {
    const Stamp stamp(table);
    EXPECT_FALSE(stamp.t) << table;
    EXPECT_NE(stamp.doubt.find("may be ns, us, ms or s"), std::string::npos) << table;
    EXPECT_NE(stamp.doubt.find("a.csv line 1"), std::string::npos) << stamp.doubt;
    EXPECT_NE(stamp.doubt.find("--stamps"), std::string::npos) << "what to do";
  }
  EXPECT_EQ(Stamp("1764140000000 0\n1764140000050 0\n").t, TimeNs{1'764'140'000'000'000'000})
      << "ms since 1970";
}

TEST(trajectory, reads_every_format_alike) {
  const TestRecording disk;
  disk.write("a.tum", "# t x y z qx qy qz qw\n10.5 1 2 3 0 0 0.6 0.8\n");
  disk.write("b.csv",
             "timestamp,x,y,z,w,x,y,z,vx,vy,vz,gx,gy,gz,ax,ay,az\n"
             "1000000000010500000,1,2,3,0.8,0,0,0.6,4,5,6,7,8,9,10,11,12\n");
  disk.write("c.txt", "10.5 0.28 -0.96 0 1 0.96 0.28 0 2 0 0 1 3\n");
  for (const char* file : {"a.tum", "b.csv", "c.txt"}) {
    const Trajectory trajectory = read_trajectory(disk.path(file));
    ASSERT_EQ(trajectory.poses.size(), 1u) << file;
    const TrajectoryPose& pose = trajectory.poses[0];
    EXPECT_EQ(pose.t % 1'000'000'000'000'000, file[0] == 'b' ? 10'500'000 : 10'500'000'000);
    EXPECT_EQ(pose.p_WB, Vec3(1, 2, 3)) << file;
    EXPECT_LT((pose.q_WB - Vec4(0, 0, 0.6, 0.8)).norm(), 1e-12) << file;
    EXPECT_EQ(trajectory.full_state, file[0] == 'b');
    if (trajectory.full_state) {
      EXPECT_EQ(pose.v_WB, Vec3(4, 5, 6));
      EXPECT_EQ(pose.b_g, Vec3(7, 8, 9));
      EXPECT_EQ(pose.b_a, Vec3(10, 11, 12));
    }
  }
}

TEST(trajectory, a_written_line_reads_back_to_the_nanosecond) {
  const TestRecording disk;
  const TimeNs t = 1403636584763555584;
  disk.write("a.tum", tum_line(t, Vec3(1, -2, 3), Vec4(0.5, -0.5, 0.5, 0.5)));
  const Trajectory trajectory = read_trajectory(disk.path("a.tum"));
  EXPECT_EQ(trajectory.poses.at(0).t, t);
  EXPECT_EQ(trajectory.poses.at(0).q_WB, Vec4(0.5, -0.5, 0.5, 0.5));
}

TEST(trajectory, bad_rows_are_named_with_their_line) {
  const char* const cases[][2] = {{"1 0 0 0 0 0 0 1\n2 0 0 0 0 0 x 1\n3 0 0 0 0 0 0 1\n", "line 2"},
                                  {"1 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n", "line 3"},
                                  {"1 0 0 0 0 0 0 1\n2 0 inf 0 0 0 0 1\n", "not finite"},
                                  {"1.0 0 0 0 0 0 0 0\n", "quaternion is zero"},
                                  {"1.0 0 0 0 0 0 0 3e190\n", "far from a unit one"},
                                  {"1.0 0 0 0\n", "8 columns"},
                                  {"", "no poses"}};
  for (const auto& [text, says] : cases) {
    const TestRecording disk;
    disk.write("a.tum", text);
    try {
      read_trajectory(disk.path("a.tum"));
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace pirvs::tools
