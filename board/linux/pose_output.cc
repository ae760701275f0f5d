#include "board/linux/pose_output.h"

#include <poll.h>
#include <unistd.h>

#include "modules/output/pose_text.h"

namespace pirvs::board {
namespace {

void put_line(TextWriter& line, TimeNs t, const SE3& T_WB, HealthState health, const Trust& trust) {
  constexpr int kDecimals = 2;
  put_tum(line, t, T_WB);
  line.put(' ').put(name(health)).put(' ');
  line.fixed(static_cast<double>(trust.confidence), kDecimals).put('\n');
}

}  // namespace

Status PoseOutput::configure(const Settings& settings, PoseFeed& feed) {
  text_ = settings.text;
  to_ = settings.poses_to;
  if (settings.has_poses_to) {
    bsp::Endpoint own;
    if (to_.address != own.address) own.address = bsp::kAnyAddress;
    const Result<bsp::Socket> socket = bsp::datagram_open(own);
    if (!socket.ok()) return socket.status();
    socket_ = socket.value();
    has_socket_ = true;
  }
  const Result<int> consumer = feed.attach();
  if (!consumer.ok()) return consumer.status();
  consumer_ = consumer.value();
  feed_ = &feed;
  return Status::kOk;
}

void PoseOutput::close() {
  if (feed_ != nullptr) feed_->detach(consumer_);
  if (has_socket_) bsp::datagram_close(socket_);
  feed_ = nullptr;
  has_socket_ = false;
}

// A pipe that can be written to has room for a line of this size, whole.
void PoseOutput::write_line(const TextWriter& line) {
  pollfd out = {STDOUT_FILENO, POLLOUT, 0};
  const bool room = poll(&out, 1, 0) == 1 && (out.revents & POLLOUT) != 0;
  const auto size = static_cast<ssize_t>(line.size());
  if (room && write(STDOUT_FILENO, line.c_str(), line.size()) == size) {
    ++written_;
  } else {
    ++dropped_;
  }
}

void PoseOutput::frame(const FrameReport& report) {
  if (text_ != TextOutput::kFrames || !report.has_pose) return;
  Text<kPoseTextMax> line;
  put_line(line, report.t, report.pose.state.T_WB, report.pose.health, report.pose.trust);
  write_line(line);
}

void PoseOutput::event(const SyncEvent& event) {
  if (text_ == TextOutput::kNone) return;
  constexpr int kNanos = 9;
  Text<kPoseTextMax> line;
  line.put("# sync_in ").fixed(to_seconds(event.edge.t), kNanos);
  line.put(event.edge.level ? " 1" : " 0");
  if (event.has_pose) {
    line.put(' ');
    put_line(line, event.edge.t, event.pose.state.T_WB, event.pose.health, event.pose.trust);
  } else {
    line.put('\n');
  }
  write_line(line);
}

void PoseOutput::send(void (*seen)(const Pose&)) {
  while (const Pose* const pose = feed_->next(consumer_)) {
    seen(*pose);
    Text<kPoseTextMax> line;
    put_line(line, pose->state.t, pose->state.T_WB, pose->health, pose->trust);
    if (text_ == TextOutput::kPoses) write_line(line);
    if (also_ != nullptr) also_(line);
    if (!has_socket_) continue;
    const Status status = bsp::datagram_send(socket_, to_, line.c_str(), line.size());
    if (status == Status::kOk) {
      ++sent_;
    } else {
      ++dropped_;
    }
  }
}

}  // namespace pirvs::board
