// The stages between a sensor and its video node, set up by a table of the board: links, formats,
// crops, range of grey. What `media-ctl` does by hand.
// In      A MediaTable: the chain of stages of one kind of ISP, and where each camera's ISP is in
//         the device tree. The size of the images. The sensor is found by the graph itself.
// Out     MediaNodes: the video node, who sends FRAME_SYNC, who has the sensor's controls.
//         Links that the chain needs are enabled, others into the same pads disabled; each pad has
//         the size, and the code that its stage says, or that of the stage before.
// Errors  False, and one line that names entity and pad and says what to do.
// Cost    About 40 system calls, when a camera is opened. No heap.
// Source  Linux, "Media Controller API" (MEDIA_IOC_G_TOPOLOGY, MEDIA_IOC_SETUP_LINK), "Sub-device
//         interface" (VIDIOC_SUBDEV_S_FMT, S_SELECTION), rkisp1.rst.
#pragma once

#include "bsp/linux/system_calls.h"
#include "core/base/text.h"

namespace pirvs::bsp {

struct MediaStage {
  static constexpr uint8_t kSink = 1, kSource = 2;
  const char* entity;
  uint16_t sink = 0, source = 1;
  uint32_t code = 0;        // of media-bus-format.h at the source; 0: as it comes
  bool optional = false;    // kernels without it link its neighbours
  uint8_t crops = 0;        // pads that are cropped to the size
  bool full_range = false;  // its source gives grey of 0 to 255
};

struct MediaTable {
  const char* driver;
  const char* parents[2];  // of camera 0 and 1, OF_FULLNAME of the ISP ends so
  const MediaStage* stages;
  int stage_count;
  const char* video;   // the last one, a video node
  const char* events;  // the stage that sends FRAME_SYNC
};

struct MediaNodes {
  static constexpr size_t kPathMax = 48;
  char video[kPathMax] = "", events[kPathMax] = "", sensor[kPathMax] = "";
};

struct MediaRequest {
  const MediaTable* table = nullptr;
  int camera = 0;
  int width = 0, height = 0;
  const char* root = "";  // before /sys; tests give a folder
};

[[nodiscard]] bool set_up_media(const MediaRequest& request, const SystemCalls& calls,
                                MediaNodes& out, TextWriter& fault);

}  // namespace pirvs::bsp
