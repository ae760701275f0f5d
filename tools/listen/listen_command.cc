// `pirvs listen [HOST]`: what a device tells over the network, on the screen and in a run folder.
#include <cmath>
#include <csignal>
#include <cstdio>
#include <iterator>
#include <memory>

#include "bsp/api/clock.h"
#include "core/math/trig.h"
#include "tools/cli/command.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/trajectory.h"
#include "tools/listen/stream_log.h"

namespace pirvs::tools {
namespace {

using stream::Kind;

constexpr TimeNs kSecond_ns = 1'000'000'000;

struct Options {
  std::string from = "192.168.7.1";
  std::string out, record;
  double duration_s = 0;
  bool poses = false;
  bool no_images = false;
};

volatile std::sig_atomic_t stop_wanted = 0;

// A line a second: where it is, how well, and what the way has cost.
class Screen {
 public:
  void show(TimeNs now, const StreamLog& log, const ClockOffset& clock) {
    if (now < next_t_) return;
    const double since_s = to_seconds(now - next_t_ + kSecond_ns);
    next_t_ = now + kSecond_ns;
    const StreamTotals& totals = log.totals();
    const double rate = double(log.poses().size() - poses_) / since_s;
    const double kB_s = double(totals.bytes - bytes_) / since_s / 1000;
    poses_ = log.poses().size();
    bytes_ = totals.bytes;
    if (log.poses().empty()) {
      std::fprintf(stderr, "no pose yet; %zu datagrams\n", totals.datagrams);
      return;
    }
    const stream::PoseMessage& pose = log.poses().back();
    std::fprintf(stderr,
                 "%.3f s  place %7.2f %7.2f %7.2f m  speed %5.2f m/s  %s %.2f  path %.1f m  "
                 "%.0f poses/s  %.1f kB/s  %zu lost",
                 to_seconds(pose.t), pose.p_WB.x(), pose.p_WB.y(), pose.p_WB.z(), pose.v_WB.norm(),
                 name(pose.health), double(pose.confidence), log.path_m(), rate, kB_s, totals.lost);
    if (clock.known) std::fprintf(stderr, "  clock +-%.2f ms", 5e-7 * double(clock.round_trip_ns));
    if (!log.fused().empty()) {
      constexpr double kDegree = kPi / 180;
      const FusedPose& fused = log.fused().back();
      const double variance_m2 = (fused.cov(3, 3) + fused.cov(4, 4)) / 2;
      std::fprintf(stderr, "  earth %.7f %.7f %.2f m +-%.2f m %s",
                   fused.place.latitude_rad / kDegree, fused.place.longitude_rad / kDegree,
                   fused.place.height_m, std::sqrt(variance_m2), name(fused.health));
    }
    if (!log.pps().empty()) {
      std::fprintf(stderr, "  pps %+.0f ppb +-%.0f ns", log.pps().back().rate_ppb,
                   double(log.pps().back().noise_ns));
    }
    std::fprintf(stderr, "\n");
  }

 private:
  TimeNs next_t_ = 0;
  size_t poses_ = 0, bytes_ = 0;
};

uint32_t wanted_kinds(const Options& options) {
  uint32_t kinds = 0;
  for (const Kind kind : {Kind::kPose, Kind::kHealth, Kind::kCounters, Kind::kPoints, Kind::kSyncIn,
                          Kind::kPps, Kind::kFused}) {
    kinds |= stream::bit(kind);
  }
  return options.no_images ? kinds : kinds | stream::bit(Kind::kThumbnail);
}

int listen_to(const Options& options) {
  Listener listener(options.from, wanted_kinds(options));
  if (!options.record.empty()) listener.record(options.record);
  StreamLog log(options.out);
  Screen screen;
  std::signal(SIGINT, [](int) { stop_wanted = 1; });
  std::signal(SIGTERM, [](int) { stop_wanted = 1; });
  const TimeNs begin = bsp::now();
  const TimeNs end = options.duration_s > 0 ? begin + from_seconds(options.duration_s) : INT64_MAX;
  bool told_silent = false;
  size_t printed = 0;
  Datagram datagram;
  while (stop_wanted == 0 && !listener.ended() && bsp::now() < end) {
    if (listener.next(datagram, kSecond_ns / 5)) log.add(datagram);
    for (; options.poses && printed < log.poses().size(); ++printed) {
      const stream::PoseMessage& pose = log.poses()[printed];
      std::fputs(tum_line(pose.t, pose.p_WB, pose.q_xyzw).c_str(), stdout);
    }
    const TimeNs now = listener.live() ? bsp::now() : datagram.t_arrival;
    if (listener.heard()) {
      screen.show(now, log, listener.clock());
    } else if (listener.live() && !told_silent && now > begin + 3 * kSecond_ns) {
      told_silent = true;
      std::fprintf(stderr,
                   "pirvs: listen: %s does not answer: does pirvsd run there, with output.stream "
                   "set to that address? Waiting.\n",
                   options.from.c_str());
    }
  }
  if (!listener.heard()) {
    throw InputError("nothing was heard", options.from,
                     "does pirvsd run there, with output.stream?");
  }
  if (!options.out.empty()) {
    log.write(options.from, listener.clock());
    std::fprintf(stderr, "%s: %zu poses, %.1f m\n", options.out.c_str(), log.poses().size(),
                 log.path_m());
  }
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("FROM", o->from,
                 "the device, HOST or HOST:PORT, or a file of --record (default: the USB link, "
                 "192.168.7.1:14560)");
  app.add_option("--out", o->out, "a run folder of what was heard");
  app.add_option("--record", o->record, "all datagrams as they come, in one file");
  app.add_option("--duration", o->duration_s, "stop after this many seconds")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--poses", o->poses, "every pose on standard output: t x y z qx qy qz qw");
  app.add_flag("--no-images", o->no_images, "ask for no thumbnails");
  return [o] { return listen_to(*o); };
}

}  // namespace

const Command kListenCommand = {"listen", "Print and record what a device tells over the network",
                                declare};

}  // namespace pirvs::tools
