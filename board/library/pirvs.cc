// The functions of pirvs.h: what comes from outside is checked here, and nowhere else.
#include "board/library/pirvs.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>

#include "board/host/board.h"
#include "board/library/slam.h"
#include "core/base/version.h"

using pirvs::Command;
using pirvs::CommandKind;
using pirvs::board::refuse;

struct pirvs_slam {
  pirvs::board::Slam slam;
};

namespace {

alignas(pirvs_slam) char memory[sizeof(pirvs_slam)];
std::atomic<pirvs_slam*> the_one{nullptr};

// Size of each struct in the first version of this interface, the least that a caller can have. For
// a struct that has grown since, specialize it with the old size.
template <class T>
constexpr uint32_t kFirst = sizeof(T);
static_assert(sizeof(pirvs_pose) == 808 && sizeof(pirvs_news) == 176 &&
              sizeof(pirvs_config) == 72 && sizeof(pirvs_imu) == 64 && sizeof(pirvs_images) == 32 &&
              sizeof(pirvs_point) == 40 && sizeof(pirvs_points) == 32 && sizeof(pirvs_state) == 80);

bool is_ours(const pirvs_slam* slam) { return slam != nullptr && slam == the_one; }

pirvs_status no_instance() { return refuse(PIRVS_BAD_ARGUMENT, "NULL, or destroyed already"); }
pirvs_status no_size() { return refuse(PIRVS_BAD_ARGUMENT, "NULL, or its `size` is not set"); }

// Copies a caller's struct, which may be of an older or newer header. Fields that it lacks are
// zero.
template <class T>
bool take(const T* from, T& out) {
  if (from == nullptr || from->size < kFirst<T>) return false;
  std::memcpy(static_cast<void*>(&out), from, std::min<size_t>(from->size, sizeof(T)));
  return true;
}

// And back, as far as his reaches; the size stays his.
template <class T>
void give(const T& from, T* to) {
  const uint32_t size = to->size;
  std::memcpy(static_cast<void*>(to), &from, std::min<size_t>(size, sizeof from));
  to->size = size;
}

template <class T, class Ask>
pirvs_status answer(pirvs_slam* slam, T* out, Ask&& ask) {
  if (!is_ours(slam)) return no_instance();
  T known{};
  if (!take(out, known)) return no_size();
  const pirvs_status status = ask(slam->slam, known);
  if (status == PIRVS_OK) give(known, out);
  return status;
}

pirvs_status name_command(pirvs_slam* slam, CommandKind kind, const char* name) {
  if (!is_ours(slam)) return no_instance();
  Command command;
  command.kind = kind;
  if (name == nullptr || name[0] == 0 || std::strlen(name) >= sizeof command.text) {
    return refuse(PIRVS_BAD_ARGUMENT, "not a name of 1 to 63 characters");
  }
  std::strcpy(command.text, name);
  return slam->slam.command(command);
}

}  // namespace

const char* pirvs_version(void) { return pirvs::kVersion; }

const char* pirvs_last_error(void) { return pirvs::board::why(); }

pirvs_status pirvs_create(const pirvs_config* config, pirvs_slam** out) {
  if (out == nullptr) return no_instance();
  *out = nullptr;
  pirvs_config known{};
  if (!take(config, known)) return no_size();
  if (known.calibration == nullptr) return refuse(PIRVS_BAD_ARGUMENT, "calibration is NULL");
  if (known.mode > PIRVS_STEPPED) return refuse(PIRVS_BAD_ARGUMENT, "no such mode");
  if (known.cores > pirvs::board::kCores) return refuse(PIRVS_BAD_ARGUMENT, "cores: 1 to 3");
  if (the_one != nullptr) return refuse(PIRVS_REFUSED, "a process has one instance");
  auto* const slam = new (memory) pirvs_slam;
  const pirvs_status status = slam->slam.create(known);
  if (status != PIRVS_OK) {
    slam->~pirvs_slam();
    return status;
  }
  the_one = slam;
  *out = slam;
  return PIRVS_OK;
}

pirvs_status pirvs_start(pirvs_slam* slam) {
  return is_ours(slam) ? slam->slam.start() : no_instance();
}

pirvs_status pirvs_feed_imu(pirvs_slam* slam, const pirvs_imu* sample) {
  if (!is_ours(slam)) return no_instance();
  pirvs_imu known{};
  return take(sample, known) ? slam->slam.feed(known) : no_size();
}

pirvs_status pirvs_feed_images(pirvs_slam* slam, const pirvs_images* images) {
  if (!is_ours(slam)) return no_instance();
  pirvs_images known{};
  return take(images, known) ? slam->slam.feed(known) : no_size();
}

pirvs_status pirvs_next_pose(pirvs_slam* slam, int which, pirvs_pose* out) {
  return answer(slam, out, [which](pirvs::board::Slam& s, pirvs_pose& pose) {
    return s.next_pose(which, pose);
  });
}

pirvs_status pirvs_next_news(pirvs_slam* slam, pirvs_news* out) {
  return answer(slam, out,
                [](pirvs::board::Slam& s, pirvs_news& news) { return s.next_news(news); });
}

pirvs_status pirvs_get_points(pirvs_slam* slam, pirvs_points* out) {
  return answer(slam, out, [](pirvs::board::Slam& s, pirvs_points& points) {
    if (points.point_size != sizeof(pirvs_point) || (points.point == nullptr && points.max > 0)) {
      return refuse(PIRVS_BAD_ARGUMENT, "no memory for points, or points of another size");
    }
    return s.points(points);
  });
}

pirvs_status pirvs_get_state(pirvs_slam* slam, pirvs_state* out) {
  return answer(slam, out, [](pirvs::board::Slam& s, pirvs_state& state) {
    s.state(state);
    return PIRVS_OK;
  });
}

pirvs_status pirvs_get_counter(pirvs_slam* slam, int index, const char** name, uint64_t* value) {
  if (!is_ours(slam)) return no_instance();
  if (name == nullptr || value == nullptr) return refuse(PIRVS_BAD_ARGUMENT, "NULL");
  return slam->slam.counter(index, *name, *value);
}

pirvs_status pirvs_set_parameter(pirvs_slam* slam, const char* name, double value) {
  if (!is_ours(slam)) return no_instance();
  if (name == nullptr || std::strlen(name) >= Command::kTextMax) {
    return refuse(PIRVS_NOT_FOUND, "no such parameter");
  }
  return slam->slam.set_parameter(name, static_cast<float>(value));
}

pirvs_status pirvs_reset(pirvs_slam* slam) {
  if (!is_ours(slam)) return no_instance();
  Command command;
  command.kind = CommandKind::kReset;
  return slam->slam.command(command);
}

pirvs_status pirvs_set_pose(pirvs_slam* slam, const double p_m[3], double yaw_rad, double sigma_m) {
  if (!is_ours(slam)) return no_instance();
  if (p_m == nullptr) return refuse(PIRVS_BAD_ARGUMENT, "p_m is NULL");
  Command command;
  command.kind = CommandKind::kSetPose;
  command.p_WB = pirvs::Vec3(p_m[0], p_m[1], p_m[2]);
  command.yaw_rad = yaw_rad;
  command.value = static_cast<float>(sigma_m);
  return slam->slam.command(command);
}

pirvs_status pirvs_save_map(pirvs_slam* slam, const char* name) {
  return name_command(slam, CommandKind::kSaveMap, name);
}

pirvs_status pirvs_load_map(pirvs_slam* slam, const char* name) {
  return name_command(slam, CommandKind::kLoadMap, name);
}

pirvs_status pirvs_stop(pirvs_slam* slam) {
  return is_ours(slam) ? slam->slam.stop() : no_instance();
}

void pirvs_destroy(pirvs_slam* slam) {
  if (!is_ours(slam)) return;
  (void)slam->slam.stop();
  the_one = nullptr;
  slam->~pirvs_slam();
}
