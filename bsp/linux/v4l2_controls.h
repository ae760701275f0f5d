// Exposure and analogue gain of one V4L2 camera.
// In      open(): the video node's descriptor, and the node of the sensor where the controls are
//         not the video node's own (rkisp1). set(): wanted exposure and gain; zeros: the camera's
//         own automatic. look(): now and then, to notice another program.
// Out     range(): what can be set. exposure_ns(): as it is set now.
//         Exposure is V4L2_CID_EXPOSURE_ABSOLUTE (units of 100 us), else V4L2_CID_EXPOSURE in lines
//         of V4L2_CID_PIXEL_RATE and HBLANK. Gain is V4L2_CID_ANALOGUE_GAIN, else GAIN, a code
//         that is proportional to the factor: gain_one means factor 1.
// Errors  None: a camera without such controls takes nothing. A code that cannot be read or set
//         stays as it was; look() tells what it is.
// Cost    open: ten system calls; set: six; look: one or two.
// Source  V4L2 API, "Camera Control Reference", "Image Source Control Reference".
#pragma once

#include "bsp/api/camera.h"
#include "bsp/linux/system_calls.h"

namespace pirvs::bsp {

struct V4l2ControlSetup {
  const char* sensor = "";  // /dev/v4l-subdevN that has the controls; "": the video node
  int gain_one = 0;         // code of factor 1; 0: the least code, if that is above 0
};

class V4l2Controls {
 public:
  // width: pixels of a line, where the sensor's node does not tell.
  void open(int video_fd, int width, const V4l2ControlSetup& setup, const SystemCalls& calls);
  void close();

  bool takes_exposure() const { return exposure_.unit > 0; }
  CameraRange range() const;
  // False: refused.
  bool set(const CameraControl& control);
  TimeNs exposure_ns() const;
  // False: another program has set exposure, or gain, which is looked at now and then.
  bool look();

 private:
  // A control that is a whole number of units.
  struct Code {
    uint32_t id = 0;
    double unit = 0;  // ns, or gain; 0: there is no such control
    int32_t min = 0, max = 0, step = 1;
    int32_t now = 0;

    double value(int32_t code) const { return static_cast<double>(code) * unit; }
    int32_t nearest(double value) const;
  };
  static constexpr int kGainEvery = 16;  // looks

  bool find(uint32_t id, double unit, Code& out);
  double line_ns(int width);
  void find_gain(int gain_one);
  bool read(uint32_t id, int32_t& value);
  bool write(uint32_t id, int32_t value);
  bool write(Code& code, double value);

  const SystemCalls* calls_ = &kSystemCalls;
  int fd_ = -1;
  bool own_fd_ = false;
  Code exposure_, gain_;
  int looks_ = 0;
};

}  // namespace pirvs::bsp
