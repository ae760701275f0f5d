// `pirvs ros2 [FROM]`: what a device tells over the network, for programs of ROS 2.
#include <csignal>
#include <cstdio>
#include <memory>

#include "bsp/api/clock.h"
#include "tools/cli/command.h"
#include "tools/dataset/input_error.h"
#include "tools/listen/listener.h"
#include "tools/ros2/topics.h"

namespace pirvs::tools {
namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;

struct Options {
  std::string from = "192.168.7.1";
  TopicOptions topics;
  double duration_s = 0;
  bool device_time = false;
};

volatile std::sig_atomic_t stop_wanted = 0;

// From the device's clock to that of this machine's day, which is what ROS stamps mean.
TimeNs offset_of(const Options& options, const Listener& listener) {
  if (options.device_time || !listener.clock().known) return 0;
  timespec day{};
  (void)clock_gettime(CLOCK_REALTIME, &day);
  const TimeNs since_epoch = TimeNs{day.tv_sec} * kSecond_ns + day.tv_nsec;
  return since_epoch - bsp::now() - listener.clock().offset_ns;
}

uint32_t wanted_kinds(const TopicOptions& topics) {
  uint32_t kinds = stream::bit(stream::Kind::kPose);
  if (!topics.imu.empty()) kinds |= stream::bit(stream::Kind::kImu);
  if (!topics.points.empty()) kinds |= stream::bit(stream::Kind::kPoints);
  return kinds;
}

// True: a pose.
bool hand_on(const Datagram& datagram, TimeNs offset_ns, Topics& topics) {
  stream::Header header;
  stream::PoseMessage pose;
  ImuSample sample;
  stream::PointsMessage points;
  if (!stream::decode(datagram.bytes, datagram.size, header)) return false;
  const uint8_t* const payload = datagram.bytes + stream::kHeaderBytes;
  if (stream::decode(header, payload, pose)) {
    topics.pose(pose, offset_ns);
    return true;
  }
  if (stream::decode(header, payload, sample)) {
    topics.imu(sample, offset_ns);
  } else if (stream::decode(header, payload, points)) {
    topics.points(points, header.part + 1 == header.parts, offset_ns);
  }
  return false;
}

int publish(const Options& options) {
  Listener listener(options.from, wanted_kinds(options.topics));
  Topics topics(options.topics);
  std::signal(SIGINT, [](int) { stop_wanted = 1; });
  std::signal(SIGTERM, [](int) { stop_wanted = 1; });
  const TimeNs begin = bsp::now();
  const TimeNs end = options.duration_s > 0 ? begin + from_seconds(options.duration_s) : INT64_MAX;
  size_t poses = 0;
  TimeNs offset_ns = 0;
  bool offset_known = false;
  Datagram datagram;
  while (stop_wanted == 0 && !listener.ended() && bsp::now() < end) {
    if (!listener.next(datagram, kSecond_ns / 5)) continue;
    // Once: stamps that follow each better measurement would run back.
    if (!offset_known && (listener.clock().known || options.device_time || !listener.live())) {
      offset_ns = offset_of(options, listener);
      offset_known = true;
    }
    if (offset_known) poses += hand_on(datagram, offset_ns, topics);
  }
  if (!listener.heard()) {
    throw InputError("nothing was heard", options.from,
                     "does pirvsd run there, with output.stream?");
  }
  std::fprintf(stderr, "%zu poses, %d readers at the end\n", poses, topics.readers());
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("FROM", o->from,
                 "the device, HOST or HOST:PORT, or a file of pirvs listen --record (default: the "
                 "USB link, 192.168.7.1:14560)");
  const auto topic = [&](const char* option, std::string& name, const char* what) {
    app.add_option(option, name, std::string("topic of ") + what + ", without the slash; '': none")
        ->capture_default_str();
  };
  topic("--odom", o->topics.odom, "nav_msgs/Odometry");
  topic("--tf", o->topics.tf, "tf2_msgs/TFMessage");
  topic("--imu", o->topics.imu, "sensor_msgs/Imu");
  topic("--points", o->topics.points, "sensor_msgs/PointCloud2, the landmarks");
  app.add_option("--frame", o->topics.frame, "frame of the world")->capture_default_str();
  app.add_option("--child", o->topics.child, "frame of the IMU")->capture_default_str();
  app.add_option("--domain", o->topics.domain, "ROS_DOMAIN_ID")
      ->capture_default_str()
      ->check(CLI::Range(0, 232));
  app.add_option("--network", o->topics.network,
                 "the address of this machine to speak on; the default is this machine alone")
      ->capture_default_str();
  app.add_flag("--device-time", o->device_time, "stamps of the device's clock");
  app.add_option("--duration", o->duration_s, "stop after this many seconds")
      ->check(CLI::NonNegativeNumber);
  return [o] { return publish(*o); };
}

}  // namespace

const Command kRos2Command = {"ros2", "Publish what a device tells on topics of ROS 2", declare};

}  // namespace pirvs::tools
