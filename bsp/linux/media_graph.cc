#include "bsp/linux/media_graph.h"

#include <errno.h>
#include <linux/media.h>
#include <linux/v4l2-subdev.h>

#include <cstring>

#include "bsp/linux/sysfs.h"

namespace pirvs::bsp {
namespace {

constexpr int kDevicesMax = 16;
constexpr size_t kUeventMax = 512;

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() >= end.size() &&
         std::memcmp(text.data() + text.size() - end.size(), end.data(), end.size()) == 0;
}

const char* why(int error) {
  switch (error) {
    case EBUSY:
      return "another program streams";
    case EACCES:
    case EPERM:
      return "no permission, group video is needed";
    case EINVAL:
      return "refused";
    default:
      return "failed";
  }
}

// One media device as the kernel shows it.
class Graph {
 public:
  Graph(const MediaRequest& request, const SystemCalls& calls, TextWriter& fault)
      : request_(request), calls_(calls), fault_(fault) {}
  ~Graph() {
    if (fd_ >= 0) calls_.close(fd_);
  }
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  bool find_device();
  bool read_topology();
  bool set_up(MediaNodes& out);

 private:
  static constexpr uint32_t kEntities = 32, kInterfaces = 32, kPads = 96, kLinks = 192;

  bool is_ours(int number);
  bool too_large() const;
  const media_v2_entity* find(const char* name) const;
  const media_v2_pad* find_pad(const media_v2_entity& entity, uint16_t index) const;
  const media_v2_entity* entity_of(uint32_t pad_id) const;
  const media_v2_entity* sensor_into(const media_v2_pad& sink) const;
  bool link(const media_v2_entity& from, const media_v2_entity& to, uint16_t to_pad,
            uint16_t& from_pad);
  bool switch_link(const media_v2_link& link, bool on);
  media_pad_desc desc_of(uint32_t pad_id) const;
  bool node_of(const media_v2_entity& entity, char* path);
  bool format(const char* node, const MediaStage& stage, uint16_t pad, bool is_source,
              uint32_t& code);
  bool crop(const char* node, const MediaStage& stage, uint16_t pad);
  bool set_up_stage(const MediaStage& stage, const media_v2_entity& entity, uint32_t& code);
  bool say(const char* entity, int pad, const char* what, const char* to_do);

  const MediaRequest& request_;
  const SystemCalls& calls_;
  TextWriter& fault_;
  int fd_ = -1;
  media_v2_entity entities_[kEntities];
  media_v2_interface interfaces_[kInterfaces];
  media_v2_pad pads_[kPads];
  media_v2_link links_[kLinks];
  media_v2_topology topology_{};
};

bool Graph::say(const char* entity, int pad, const char* what, const char* to_do) {
  fault_.clear();
  fault_.put(entity);
  if (pad >= 0) fault_.put(" pad ").number(pad);
  fault_.put(": ").put(what).put(", ").put(to_do);
  return false;
}

// ---- the device --------------------------------------------------------------------------------

// By where its ISP stands in the device tree: two of one driver differ in nothing else.
bool Graph::is_ours(int number) {
  media_device_info info{};
  if (calls_.ioctl(fd_, MEDIA_IOC_DEVICE_INFO, &info) < 0) return false;
  if (std::strcmp(info.driver, request_.table->driver) != 0) return false;
  Text<128> path;
  path.put(request_.root).put("/sys/bus/media/devices/media").number(number).put("/../uevent");
  char uevent[kUeventMax];
  if (!read_file(path.c_str(), uevent, sizeof uevent)) return false;
  return ends_with(value_of(uevent, "OF_FULLNAME"), request_.table->parents[request_.camera]);
}

bool Graph::find_device() {
  bool denied = false;
  for (int number = 0; number < kDevicesMax; ++number) {
    Text<32> path;
    path.put("/dev/media").number(number);
    fd_ = calls_.open(path.c_str());
    if (fd_ < 0) {
      denied |= errno == EACCES || errno == EPERM;
      continue;
    }
    if (is_ours(number)) return true;
    calls_.close(fd_);
    fd_ = -1;
  }
  const char* const parent = request_.table->parents[request_.camera];
  if (denied) return say(parent, -1, "a media device cannot be opened", "group video is needed");
  return say(parent, -1, "no media device of this ISP",
             "is it enabled in the device tree, and its driver loaded?");
}

bool Graph::too_large() const {
  return topology_.num_entities > kEntities || topology_.num_interfaces > kInterfaces ||
         topology_.num_pads > kPads || topology_.num_links > kLinks;
}

bool Graph::read_topology() {
  const char* const driver = request_.table->driver;
  const bool counted = calls_.ioctl(fd_, MEDIA_IOC_G_TOPOLOGY, &topology_) == 0;
  if (!counted) return say(driver, -1, "no topology", "Linux 4.19 or later is needed");
  if (too_large()) return say(driver, -1, "more stages than this program holds", "report it");
  topology_.ptr_entities = reinterpret_cast<uintptr_t>(entities_);
  topology_.ptr_interfaces = reinterpret_cast<uintptr_t>(interfaces_);
  topology_.ptr_pads = reinterpret_cast<uintptr_t>(pads_);
  topology_.ptr_links = reinterpret_cast<uintptr_t>(links_);
  const bool read = calls_.ioctl(fd_, MEDIA_IOC_G_TOPOLOGY, &topology_) == 0;
  return read || say(driver, -1, "its stages changed while they were read", "trying again");
}

// ---- looking things up -------------------------------------------------------------------------

const media_v2_entity* Graph::find(const char* name) const {
  for (uint32_t i = 0; i < topology_.num_entities; ++i) {
    if (std::strcmp(entities_[i].name, name) == 0) return &entities_[i];
  }
  return nullptr;
}

const media_v2_pad* Graph::find_pad(const media_v2_entity& entity, uint16_t index) const {
  for (uint32_t i = 0; i < topology_.num_pads; ++i) {
    if (pads_[i].entity_id == entity.id && pads_[i].index == index) return &pads_[i];
  }
  return nullptr;
}

const media_v2_entity* Graph::entity_of(uint32_t pad_id) const {
  for (uint32_t i = 0; i < topology_.num_pads; ++i) {
    if (pads_[i].id != pad_id) continue;
    for (uint32_t k = 0; k < topology_.num_entities; ++k) {
      if (entities_[k].id == pads_[i].entity_id) return &entities_[k];
    }
  }
  return nullptr;
}

media_pad_desc Graph::desc_of(uint32_t pad_id) const {
  media_pad_desc out{};
  for (uint32_t i = 0; i < topology_.num_pads; ++i) {
    if (pads_[i].id != pad_id) continue;
    out.entity = pads_[i].entity_id;
    out.index = static_cast<uint16_t>(pads_[i].index);
    out.flags = pads_[i].flags;
  }
  return out;
}

bool is_data(const media_v2_link& link) {
  return (link.flags & MEDIA_LNK_FL_LINK_TYPE) == MEDIA_LNK_FL_DATA_LINK;
}

// The sensor whose link is on, or the only one.
const media_v2_entity* Graph::sensor_into(const media_v2_pad& sink) const {
  const media_v2_entity* only = nullptr;
  int count = 0;
  for (uint32_t i = 0; i < topology_.num_links; ++i) {
    if (!is_data(links_[i]) || links_[i].sink_id != sink.id) continue;
    const media_v2_entity* const from = entity_of(links_[i].source_id);
    if (from == nullptr || from->function != MEDIA_ENT_F_CAM_SENSOR) continue;
    if ((links_[i].flags & MEDIA_LNK_FL_ENABLED) != 0) return from;
    only = from;
    ++count;
  }
  return count == 1 ? only : nullptr;
}

bool Graph::node_of(const media_v2_entity& entity, char* path) {
  for (uint32_t i = 0; i < topology_.num_links; ++i) {
    const media_v2_link& link = links_[i];
    if (is_data(link) || link.sink_id != entity.id) continue;
    for (uint32_t k = 0; k < topology_.num_interfaces; ++k) {
      if (interfaces_[k].id != link.source_id) continue;
      Text<128> file;
      file.put(request_.root).put("/sys/dev/char/").unsigned_number(interfaces_[k].devnode.major);
      file.put(':').unsigned_number(interfaces_[k].devnode.minor).put("/uevent");
      char uevent[kUeventMax];
      if (!read_file(file.c_str(), uevent, sizeof uevent)) continue;
      TextWriter out(path, MediaNodes::kPathMax);
      out.put("/dev/");
      for (const char c : value_of(uevent, "DEVNAME")) out.put(c);
      return !out.full();
    }
  }
  return say(entity.name, -1, "it has no device node",
             "the kernel needs CONFIG_VIDEO_V4L2_SUBDEV_API");
}

// ---- links -------------------------------------------------------------------------------------

bool Graph::switch_link(const media_v2_link& link, bool on) {
  const bool is_on = (link.flags & MEDIA_LNK_FL_ENABLED) != 0;
  if (is_on == on) return true;
  media_link_desc desc{};
  desc.source = desc_of(link.source_id);
  desc.sink = desc_of(link.sink_id);
  desc.flags = on ? MEDIA_LNK_FL_ENABLED : 0;
  if (calls_.ioctl(fd_, MEDIA_IOC_SETUP_LINK, &desc) == 0) return true;
  const media_v2_entity* const from = entity_of(link.source_id);
  return say(from != nullptr ? from->name : "a stage", desc.source.index,
             on ? "its link cannot be enabled" : "its link cannot be disabled", why(errno));
}

// Nothing but `from` comes into this pad.
bool Graph::link(const media_v2_entity& from, const media_v2_entity& to, uint16_t to_pad,
                 uint16_t& from_pad) {
  const media_v2_pad* const sink = find_pad(to, to_pad);
  if (sink == nullptr)
    return say(to.name, to_pad, "no such pad", "another kernel's table is needed");
  const media_v2_link* wanted = nullptr;
  for (uint32_t i = 0; i < topology_.num_links; ++i) {
    if (!is_data(links_[i]) || links_[i].sink_id != sink->id) continue;
    if (entity_of(links_[i].source_id) == &from) {
      wanted = &links_[i];
    } else if (!switch_link(links_[i], false)) {
      return false;
    }
  }
  if (wanted == nullptr) {
    fault_.clear();
    fault_.put(to.name).put(" pad ").number(to_pad).put(": no link from ").put(from.name);
    fault_.put(", another kernel's table is needed");
    return false;
  }
  from_pad = desc_of(wanted->source_id).index;
  return switch_link(*wanted, true);
}

// ---- formats -----------------------------------------------------------------------------------

bool Graph::format(const char* node, const MediaStage& stage, uint16_t pad, bool is_source,
                   uint32_t& code) {
  const int fd = calls_.open(node);
  if (fd < 0) return say(stage.entity, pad, "its node cannot be opened", why(errno));
  v4l2_subdev_format wanted{};
  wanted.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  wanted.pad = pad;
  // A sensor's code stays its own; so does everything that nobody asks for.
  bool good = calls_.ioctl(fd, VIDIOC_SUBDEV_G_FMT, &wanted) == 0;
  v4l2_mbus_framefmt& f = wanted.format;
  f.width = static_cast<uint32_t>(request_.width);
  f.height = static_cast<uint32_t>(request_.height);
  f.field = V4L2_FIELD_NONE;
  if (code != 0) f.code = code;
  const uint32_t asked = f.code;
  if (is_source && stage.full_range) {
    f.flags |= V4L2_MBUS_FRAMEFMT_SET_CSC;
    f.quantization = V4L2_QUANTIZATION_FULL_RANGE;
  }
  good &= calls_.ioctl(fd, VIDIOC_SUBDEV_S_FMT, &wanted) == 0;
  const int error = errno;
  calls_.close(fd);
  if (!good) return say(stage.entity, pad, "its format cannot be set", why(error));
  const bool size = f.width == static_cast<uint32_t>(request_.width) &&
                    f.height == static_cast<uint32_t>(request_.height);
  if (!size) return say(stage.entity, pad, "it refuses the size", "calibrate for one that it has");
  if (code != 0 && f.code != asked)
    return say(stage.entity, pad, "it refuses the code", "correct the table");
  code = f.code;
  return true;
}

bool Graph::crop(const char* node, const MediaStage& stage, uint16_t pad) {
  const int fd = calls_.open(node);
  if (fd < 0) return say(stage.entity, pad, "its node cannot be opened", why(errno));
  v4l2_subdev_selection wanted{};
  wanted.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  wanted.pad = pad;
  wanted.target = V4L2_SEL_TGT_CROP;
  wanted.r.width = static_cast<uint32_t>(request_.width);
  wanted.r.height = static_cast<uint32_t>(request_.height);
  const bool good = calls_.ioctl(fd, VIDIOC_SUBDEV_S_SELECTION, &wanted) == 0;
  const int error = errno;
  calls_.close(fd);
  return good || say(stage.entity, pad, "its crop cannot be set", why(error));
}

// From its sink to its source, as the kernel propagates: a format first, then what is cut off.
bool Graph::set_up_stage(const MediaStage& stage, const media_v2_entity& entity, uint32_t& code) {
  char node[MediaNodes::kPathMax];
  if (!node_of(entity, node) || !format(node, stage, stage.sink, false, code)) return false;
  if ((stage.crops & MediaStage::kSink) != 0 && !crop(node, stage, stage.sink)) return false;
  if ((stage.crops & MediaStage::kSource) != 0 && !crop(node, stage, stage.source)) return false;
  if (stage.code != 0) code = stage.code;
  return format(node, stage, stage.source, true, code);
}

bool Graph::set_up(MediaNodes& out) {
  const MediaTable& table = *request_.table;
  const media_v2_entity* from = nullptr;
  uint32_t code = 0;
  uint16_t from_pad = 0;
  for (int i = 0; i < table.stage_count; ++i) {
    const MediaStage& stage = table.stages[i];
    const media_v2_entity* const entity = find(stage.entity);
    if (entity == nullptr && stage.optional) continue;
    if (entity == nullptr) {
      return say(stage.entity, -1, "no such stage", "another kernel's table is needed");
    }
    if (from == nullptr) {
      const media_v2_pad* const sink = find_pad(*entity, stage.sink);
      from = sink != nullptr ? sensor_into(*sink) : nullptr;
      if (from == nullptr) {
        return say(stage.entity, stage.sink, "no sensor, or several and none linked",
                   "is it in the device tree, and does it answer on its bus?");
      }
      if (!link(*from, *entity, stage.sink, from_pad) || !node_of(*from, out.sensor)) return false;
      MediaStage sensor{from->name};
      if (!format(out.sensor, sensor, from_pad, true, code)) return false;
    } else if (!link(*from, *entity, stage.sink, from_pad)) {
      return false;
    }
    if (!set_up_stage(stage, *entity, code)) return false;
    if (std::strcmp(stage.entity, table.events) == 0 && !node_of(*entity, out.events)) return false;
    from = entity;
  }
  const media_v2_entity* const video = find(table.video);
  if (video == nullptr) return say(table.video, -1, "no such stage", "another table is needed");
  return link(*from, *video, 0, from_pad) && node_of(*video, out.video);
}

}  // namespace

bool set_up_media(const MediaRequest& request, const SystemCalls& calls, MediaNodes& out,
                  TextWriter& fault) {
  Graph graph(request, calls, fault);
  return graph.find_device() && graph.read_topology() && graph.set_up(out);
}

}  // namespace pirvs::bsp
