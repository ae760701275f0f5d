// Two ISPs with a sensor each, against a kernel and a sysfs of our own.
#include "bsp/linux/media_graph.h"

#include <gtest/gtest.h>

#include <errno.h>
#include <linux/media-bus-format.h>
#include <linux/media.h>
#include <linux/v4l2-subdev.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace pirvs::bsp {
namespace {

namespace fs = std::filesystem;

constexpr MediaStage kStages[] = {
    {"csi", 0, 1, 0, true},
    {"isp", 0, 2, MEDIA_BUS_FMT_YUYV8_2X8, false, MediaStage::kSink | MediaStage::kSource, true},
    {"resizer", 0, 1, 0, false, MediaStage::kSink},
};
constexpr MediaTable kTable = {"rkisp1", {"isp0@ff910000", "isp1@ff920000"}, kStages, 3, "mainpath",
                               "isp"};

struct Pad {
  v4l2_mbus_framefmt format{};
  v4l2_rect crop{};
};
struct Entity {
  std::string name;
  uint32_t function = 0;
  int pads = 2;
  int minor = 0;
  std::map<int, Pad> state;
};
struct Link {
  int from, from_pad, to, to_pad;
  uint32_t flags;
};
struct Isp {
  std::string driver = "rkisp1";
  std::vector<Entity> entities;
  std::vector<Link> links;
  int error_on_link = 0;
};
struct World {
  Isp isps[2];
  uint32_t width_max = 1280;
  int open = 0;
} world;

int failed(int error) {
  errno = error;
  return -1;
}

// Ids as a kernel gives them: any number, each once.
uint32_t entity_id(size_t i) { return 1000 + uint32_t(i); }
uint32_t pad_id(int entity, int pad) { return uint32_t(2000 + 10 * entity + pad); }

int get_topology(const Isp& isp, media_v2_topology& out) {
  std::vector<media_v2_entity> entities;
  std::vector<media_v2_interface> interfaces;
  std::vector<media_v2_pad> pads;
  std::vector<media_v2_link> links;
  for (size_t i = 0; i < isp.entities.size(); ++i) {
    const Entity& e = isp.entities[i];
    media_v2_entity entity{};
    entity.id = entity_id(i);
    entity.function = e.function;
    std::strcpy(entity.name, e.name.c_str());
    entities.push_back(entity);
    media_v2_interface interface {};
    interface.id = 3000 + uint32_t(i);
    interface.devnode.major = 81;
    interface.devnode.minor = uint32_t(e.minor);
    interfaces.push_back(interface);
    media_v2_link link{};
    link.source_id = interface.id;
    link.sink_id = entity.id;
    link.flags = MEDIA_LNK_FL_INTERFACE_LINK;
    links.push_back(link);
    for (int p = 0; p < e.pads; ++p) {
      media_v2_pad pad{};
      pad.id = pad_id(int(i), p);
      pad.entity_id = entity.id;
      pad.index = uint32_t(p);
      pads.push_back(pad);
    }
  }
  for (const Link& l : isp.links) {
    media_v2_link link{};
    link.source_id = pad_id(l.from, l.from_pad);
    link.sink_id = pad_id(l.to, l.to_pad);
    link.flags = l.flags;
    links.push_back(link);
  }
  // The count that came in is what there is room for; 0: the caller only counts.
  const auto copy = [](const auto& from, uint64_t to, uint32_t room) {
    if (to != 0) std::memcpy(reinterpret_cast<void*>(to), from.data(), sizeof(from[0]) * room);
    return uint32_t(from.size());
  };
  out.num_entities = copy(entities, out.ptr_entities, out.num_entities);
  out.num_interfaces = copy(interfaces, out.ptr_interfaces, out.num_interfaces);
  out.num_pads = copy(pads, out.ptr_pads, out.num_pads);
  out.num_links = copy(links, out.ptr_links, out.num_links);
  return 0;
}

int set_up_link(Isp& isp, const media_link_desc& wanted) {
  if (isp.error_on_link != 0) return failed(isp.error_on_link);
  for (Link& link : isp.links) {
    const bool same = entity_id(size_t(link.from)) == wanted.source.entity &&
                      link.from_pad == wanted.source.index &&
                      entity_id(size_t(link.to)) == wanted.sink.entity &&
                      link.to_pad == wanted.sink.index;
    if (!same) continue;
    if ((link.flags & MEDIA_LNK_FL_IMMUTABLE) != 0) return failed(EINVAL);
    link.flags = wanted.flags;
    return 0;
  }
  return failed(EINVAL);
}

// Media devices are 10 and 11, subdevs 100 and their minor.
int open_node(const char* path) {
  const std::string name = path;
  ++world.open;
  if (name == "/dev/media2") return 10;  // the numbers are as they come
  if (name == "/dev/media0") return 11;
  if (name.rfind("/dev/v4l-subdev", 0) == 0) return 100 + std::stoi(name.substr(15));
  --world.open;
  return failed(ENOENT);
}

int close_node(int) {
  --world.open;
  return 0;
}

Entity* entity_of(int fd) {
  for (Isp& isp : world.isps) {
    for (Entity& entity : isp.entities) {
      if (entity.minor == fd - 100) return &entity;
    }
  }
  return nullptr;
}

int subdev_ioctl(Entity& entity, unsigned long request, void* argument) {
  if (request == VIDIOC_SUBDEV_G_FMT || request == VIDIOC_SUBDEV_S_FMT) {
    auto& format = *static_cast<v4l2_subdev_format*>(argument);
    if (int(format.pad) >= entity.pads) return failed(EINVAL);
    v4l2_mbus_framefmt& kept = entity.state[int(format.pad)].format;
    if (request == VIDIOC_SUBDEV_S_FMT) {
      kept = format.format;
      kept.width = std::min(kept.width, world.width_max);
      if (entity.function == MEDIA_ENT_F_CAM_SENSOR) kept.code = MEDIA_BUS_FMT_Y8_1X8;
    }
    format.format = kept;
    return 0;
  }
  if (request != VIDIOC_SUBDEV_S_SELECTION) return failed(ENOTTY);
  const auto& selection = *static_cast<v4l2_subdev_selection*>(argument);
  entity.state[int(selection.pad)].crop = selection.r;
  return 0;
}

int node_ioctl(int fd, unsigned long request, void* argument) {
  if (fd >= 100) return subdev_ioctl(*entity_of(fd), request, argument);
  Isp& isp = world.isps[fd - 10];
  switch (request) {
    case MEDIA_IOC_DEVICE_INFO:
      std::strcpy(static_cast<media_device_info*>(argument)->driver, isp.driver.c_str());
      return 0;
    case MEDIA_IOC_G_TOPOLOGY:
      return get_topology(isp, *static_cast<media_v2_topology*>(argument));
    case MEDIA_IOC_SETUP_LINK:
      return set_up_link(isp, *static_cast<media_link_desc*>(argument));
    default:
      return failed(ENOTTY);
  }
}

constexpr SystemCalls kKernel = {open_node, close_node, node_ioctl, nullptr, nullptr};
constexpr uint32_t kOn = MEDIA_LNK_FL_ENABLED;
enum : int { kSensor, kCsi, kIspStage, kResizer, kMainpath, kOther };

class MediaGraphTest : public testing::Test {
 protected:
  MediaGraphTest() {
    root_ = (fs::temp_directory_path() / ("media_" + std::to_string(getpid()))).string();
    fs::remove_all(root_);
    world = World{};
    for (int i = 0; i < 2; ++i) add_isp(i);
  }
  ~MediaGraphTest() override { fs::remove_all(root_); }

  void write(const std::string& path, const std::string& text) {
    fs::create_directories(fs::path(root_ + path).parent_path());
    std::ofstream(root_ + path) << text;
  }
  void add_isp(int i) {
    const int first = 10 * (i + 1);
    Isp& isp = world.isps[i];
    isp.entities = {
        {"ov9281 " + std::to_string(i + 1) + "-0060", MEDIA_ENT_F_CAM_SENSOR, 1, first, {}},
        {"csi", 0, 2, first + 1, {}},
        {"isp", 0, 4, first + 2, {}},
        {"resizer", 0, 2, first + 3, {}},
        {"mainpath", 0, 1, first + 4, {}},
        {"imx219 9-0010", MEDIA_ENT_F_CAM_SENSOR, 1, first + 5, {}}};
    isp.links = {{kSensor, 0, kCsi, 0, 0},
                 {kOther, 0, kCsi, 0, 0},
                 {kCsi, 1, kIspStage, 0, kOn},
                 {kIspStage, 2, kResizer, 0, 0},
                 {kResizer, 1, kMainpath, 0, kOn | MEDIA_LNK_FL_IMMUTABLE}};
    isp.links[0].flags = kOn;
    isp.entities[kSensor].state[0].format.code = MEDIA_BUS_FMT_Y8_1X8;
    for (const Entity& e : isp.entities) {
      const bool video = e.name == "mainpath";
      write("/sys/dev/char/81:" + std::to_string(e.minor) + "/uevent",
            "MAJOR=81\nMINOR=1\nDEVNAME=" + std::string(video ? "video" : "v4l-subdev") +
                std::to_string(e.minor) + "\n");
    }
    const std::string parent = "/sys/devices/platform/isp" + std::to_string(i);
    const int number = i == 0 ? 2 : 0;
    write(parent + "/uevent", "DRIVER=rkisp1\nOF_FULLNAME=/isp" + std::to_string(i) + "@ff9" +
                                  std::to_string(i + 1) + "0000\n");
    const std::string media = "/media" + std::to_string(number);
    fs::create_directories(root_ + parent + media);
    fs::create_directories(root_ + "/sys/bus/media/devices");
    fs::create_symlink(root_ + parent + media, root_ + "/sys/bus/media/devices" + media);
  }
  bool set_up(int camera) {
    const MediaRequest request = {&kTable, camera, 640, 480, root_.c_str()};
    const bool good = set_up_media(request, kKernel, nodes_, fault_);
    EXPECT_EQ(world.open, 0) << "nodes are closed";
    return good;
  }

  std::string root_;
  MediaNodes nodes_;
  Text<160> fault_;
};

TEST_F(MediaGraphTest, SetsUpTheChainOfTheRightIsp) {
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(set_up(i)) << fault_.c_str();
    const int first = 10 * (i + 1);
    EXPECT_EQ(nodes_.sensor, "/dev/v4l-subdev" + std::to_string(first));
    EXPECT_EQ(nodes_.events, "/dev/v4l-subdev" + std::to_string(first + 2));
    EXPECT_EQ(nodes_.video, "/dev/video" + std::to_string(first + 4));
    Isp& isp = world.isps[i];
    EXPECT_EQ(isp.links[3].flags & kOn, kOn);
    for (const int stage : {kCsi, kIspStage}) {
      EXPECT_EQ(isp.entities[size_t(stage)].state[0].format.code, uint32_t(MEDIA_BUS_FMT_Y8_1X8));
    }
    const Pad& source = isp.entities[kIspStage].state[2];
    EXPECT_EQ(source.format.code, uint32_t(MEDIA_BUS_FMT_YUYV8_2X8));
    EXPECT_EQ(source.format.quantization, uint32_t(V4L2_QUANTIZATION_FULL_RANGE));
    EXPECT_EQ(source.crop.width, 640u);
    EXPECT_EQ(isp.entities[kResizer].state[0].crop.height, 480u);
    EXPECT_EQ(isp.entities[kResizer].state[1].format.code, uint32_t(MEDIA_BUS_FMT_YUYV8_2X8));
  }
}

TEST_F(MediaGraphTest, OneSensorIsLinkedAndTheOthersAreNot) {
  Isp& isp = world.isps[0];
  isp.links[0].flags = 0;
  isp.links[1].flags = kOn;
  ASSERT_TRUE(set_up(0)) << fault_.c_str();
  EXPECT_STREQ(nodes_.sensor, "/dev/v4l-subdev15") << "the one that is linked stays it";
  isp.links[1].flags = 0;
  EXPECT_FALSE(set_up(0));
  EXPECT_STREQ(fault_.c_str(),
               "csi pad 0: no sensor, or several and none linked, is it in the device tree, and "
               "does it answer on its bus?");
  isp.links.erase(isp.links.begin() + 1);
  EXPECT_TRUE(set_up(0)) << "the only one";
  EXPECT_EQ(isp.links[0].flags, kOn);
}

TEST_F(MediaGraphTest, AKernelWithoutTheOptionalStageIsFine) {
  Isp& isp = world.isps[0];
  isp.entities[kCsi].name = "gone";
  isp.links = {{kSensor, 0, kIspStage, 0, 0},
               {kIspStage, 2, kResizer, 0, 0},
               {kResizer, 1, kMainpath, 0, kOn | MEDIA_LNK_FL_IMMUTABLE}};
  EXPECT_TRUE(set_up(0)) << fault_.c_str();
  EXPECT_EQ(isp.links[0].flags, kOn);
}

TEST_F(MediaGraphTest, EachFaultNamesItsPad) {
  struct Broken {
    const char* what;
    void (*breaks)(Isp&);
  };
  const Broken kBroken[] = {
      {"isp0@ff910000: no media device of this ISP, is it enabled in the device tree, and its "
       "driver loaded?",
       [](Isp& isp) { isp.driver = "uvcvideo"; }},
      {"isp: no such stage, another kernel's table is needed",
       [](Isp& isp) { isp.entities[kIspStage].name = "isp_v2"; }},
      {"resizer pad 0: no link from isp, another kernel's table is needed",
       [](Isp& isp) { isp.links.erase(isp.links.begin() + 3); }},
      {"isp pad 2: its link cannot be enabled, another program streams",
       [](Isp& isp) { isp.error_on_link = EBUSY; }},
      {"ov9281 1-0060 pad 0: it refuses the size, calibrate for one that it has",
       [](Isp&) { world.width_max = 600; }},
  };
  for (const Broken& broken : kBroken) {
    const World before = world;
    broken.breaks(world.isps[0]);
    EXPECT_FALSE(set_up(0));
    EXPECT_STREQ(fault_.c_str(), broken.what);
    world = before;
  }
  ASSERT_TRUE(set_up(0));
}

}  // namespace
}  // namespace pirvs::bsp
